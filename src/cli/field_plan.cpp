#include "cli/field_plan.hpp"

#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {
bool writes_field(const ConvertFlags& flags) {
  if (flags.format) return !flags.format->mesh && !flags.format->picture;
  return flags.output && extension_of(*flags.output) == fmt::format(".{}", kFieldFormat);
}

Result<void> check_field_options(const ConvertFlags& flags) {
  if (!writes_field(flags)) {
    if (!flags.half) return {};
    return refuse_usage("--half is about a field that is stored, and a mesh is written", "name the output .vdb");
  }
  std::vector<std::string_view> given;
  for (const Option* option : flags.set_about(About::surface)) given.push_back(option->name());
  if (!given.empty()) {
    const std::string names = fmt::format("{}", fmt::join(given, ", "));
    return refuse_usage(fmt::format("{} {} about a surface, and the output is the field itself, in which there is none",
                                    names, given.size() == 1 ? "is" : "are"),
                        fmt::format("leave {} out, or name the output as a mesh", names));
  }
  if (flags.surface.nan == extract::NanPolicy::hole) {
    return refuse_usage("--nan hole is about a surface: samples that are not numbers are stored as they are");
  }
  if (flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage(fmt::format("-o {}: a field has no iso value", *flags.output));
  }
  return {};
}

Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles) {
  if (surface.filters.empty() || !particles.method) return {};
  if (points::method_info(*particles.method).kind == field::FieldKind::level_set) return {};
  return refuse_usage(
      fmt::format("--filter is for level sets, and --particles {} makes a density", word_of(*particles.method)),
      "--particles spheres and --particles smooth make level sets");
}

}  // namespace isoextract::cli

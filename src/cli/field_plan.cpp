#include "cli/field_plan.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/plan_parts.hpp"

namespace isoextract::cli {
std::optional<volume_io::VolumeFileFormat> field_format(const ConvertFlags& flags) {
  if (flags.format) return flags.format->field;
  if (!flags.output) return std::nullopt;
  const auto format = volume_io::volume_file_format_by_path(*flags.output);
  return format && std::ranges::find(kFieldFormats, *format) != kFieldFormats.end() ? format : std::nullopt;
}

Result<void> check_field_options(const ConvertFlags& flags) {
  const auto format = field_format(flags);
  if (!format) {
    if (!flags.half) return {};
    return refuse_usage("--half applies to a stored field, but the output is not a field",
                        "give an output name that ends in .vdb or .npy");
  }
  if (flags.half && !volume_io::can_store(*format, field::SampleType::f16)) {
    return refuse_usage(fmt::format("--half does not work with {}, which has no 16-bit floats", word_of(*format)),
                        "use .vdb or .npy, or leave --half out");
  }
  std::vector<std::string_view> given;
  for (const Option* option : flags.set_about(About::surface)) given.push_back(option->name());
  if (!given.empty()) {
    const std::string names = fmt::format("{}", fmt::join(given, ", "));
    return refuse_usage(
        fmt::format("{} {} a surface, but the output is the field itself", names, given.size() == 1 ? "needs" : "need"),
        fmt::format("leave {} out, or give the output a name of a mesh format", names));
  }
  if (flags.surface.nan == extract::NanPolicy::hole) {
    return refuse_usage(
        "--nan hole needs a surface, but the output is the field itself, which keeps NaN samples unchanged",
        "leave --nan out");
  }
  if (flags.output && flags.output->find("{iso}") != std::string::npos) {
    return refuse_usage(
        fmt::format("-o {}: {{iso}} is the iso value of a surface, but the output is the field itself", *flags.output),
        "leave {iso} out");
  }
  return {};
}

Result<void> check_filters(const SurfaceFlags& surface, const ParticleFlags& particles) {
  if (surface.filters.empty() || !particles.method) return {};
  if (points::method_info(*particles.method).kind == field::FieldKind::level_set) return {};
  return refuse_usage(
      fmt::format("--filter works on level sets, and --particles {} makes a density", word_of(*particles.method)),
      "use --particles spheres or --particles smooth, which make level sets");
}

}  // namespace isoextract::cli

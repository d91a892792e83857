#include "cli/field_plan.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/edit_plan.hpp"
#include "cli/plan_parts.hpp"

namespace isoextract::cli {
namespace {

// What is about surfaces, and was given.
std::vector<std::string_view> surface_options(const ConvertFlags& flags) {
  const SurfaceFlags& surface = flags.surface;
  const std::array<std::pair<bool, std::string_view>, 36> options{{{flags.labels.has_value(), "--labels"},
                                                                   {flags.label_names.has_value(), "--label-names"},
                                                                   {flags.relaxations.has_value(), "--relax"},
                                                                   {flags.no_merge, "--no-merge"},
                                                                   {flags.t_junctions, "--t-junctions"},
                                                                   {!flags.isos.empty(), "--iso"},
                                                                   {flags.batch.iso_table.has_value(), "--iso-table"},
                                                                   {surface.method.has_value(), "--method"},
                                                                   {flags.normals.has_value(), "--normals"},
                                                                   {flags.simplify.has_value(), "--simplify"},
                                                                   {flags.triangles.has_value(), "--triangles"},
                                                                   {surface.roi.has_value(), "--roi"},
                                                                   {surface.roi_snap, "--roi-snap"},
                                                                   {!surface.clip.empty(), "--clip"},
                                                                   {surface.cap, "--cap"},
                                                                   {!flags.attributes.empty(), "--attribute"},
                                                                   {flags.colour.has_value(), "--color-by"},
                                                                   {flags.opacity.has_value(), "--opacity"},
                                                                   {flags.batch.animate, "--animate"},
                                                                   {flags.batch.plot.has_value(), "--plot"},
                                                                   {flags.placement.space.has_value(), "--space"},
                                                                   {flags.placement.up.has_value(), "--up"},
                                                                   {flags.placement.scale.has_value(), "--scale"},
                                                                   {flags.placement.unit.has_value(), "--unit"},
                                                                   {flags.placement.to_unit.has_value(), "--to-unit"},
                                                                   {flags.placement.up_out.has_value(), "--up-out"},
                                                                   {flags.placement.to_space.has_value(), "--to-space"},
                                                                   {flags.placement.center, "--center"},
                                                                   {flags.ascii, "--ascii"},
                                                                   {flags.draco.has_value(), "--draco"},
                                                                   {flags.quantize, "--quantize"},
                                                                   {flags.meshopt, "--meshopt"},
                                                                   {flags.optimize_order, "--optimize-order"},
                                                                   {flags.error.has_value(), "--error"},
                                                                   {flags.verify, "--verify"},
                                                                   {flags.backend.has_value(), "--backend"}}};
  std::vector<std::string_view> given;
  for (const auto& [is_given, name] : options) {
    if (is_given) given.push_back(name);
  }
  if (const std::string_view edit = edit_option(flags.edits); !edit.empty()) given.push_back(edit);
  return given;
}

}  // namespace

bool writes_field(const ConvertFlags& flags) {
  if (flags.format) return !flags.format->mesh && !flags.format->picture;
  return flags.output && extension_of(*flags.output) == fmt::format(".{}", kFieldFormat);
}

Result<void> check_field_options(const ConvertFlags& flags) {
  if (!writes_field(flags)) {
    if (!flags.half) return {};
    return refuse_usage("--half is about a field that is stored, and a mesh is written", "name the output .vdb");
  }
  if (const auto given = surface_options(flags); !given.empty()) {
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

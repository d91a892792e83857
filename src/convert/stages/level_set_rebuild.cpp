#include "convert/stages/level_set_rebuild.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "base/stopwatch.hpp"
#include "convert/field_label.hpp"
#include "field/resample.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

constexpr double kRounding = 1e-6;
constexpr double kHalfBand = 3;  // openvdb::LEVEL_SET_HALF_WIDTH

bool is_close(double a, double b) { return std::abs(a - b) <= kRounding * std::abs(b); }

glm::dvec3 edges_of(const field::Affine& index_to_world) {
  const glm::dmat3& axes = index_to_world.linear;
  return {glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])};
}

bool has_perpendicular_axes(const field::Affine& index_to_world) {
  const glm::dmat3& axes = index_to_world.linear;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3& a = axes[axis];
    const glm::dvec3& b = axes[(axis + 1) % 3];
    if (std::abs(glm::dot(a, b)) > kRounding * glm::length(a) * glm::length(b)) return false;
  }
  return true;
}

// Maps new to old indices. A voxel size keeps sample (0, 0, 0) and is exact; a resolution covers the box of resample().
field::Affine requested_lattice(const SourceOptions& options, const field::ScalarField& field) {
  if (options.voxel_size) return field::scaling(*options.voxel_size / edges_of(field.index_to_world));
  const field::IndexBox box = field::resampled_box(field);
  field::Affine lattice =
      field::scaling(glm::dvec3(box.dims() - glm::i64vec3(1)) / glm::dvec3(*options.resolution - 1));
  lattice.offset = box.min;
  return lattice;
}

// Returns why resampling interpolates instead of rebuilding the level set; empty if it rebuilds.
std::string why_interpolated(const SourceOptions& options, volume_io::VolumeFileFormat format,
                             const field::Affine& index_to_world, const glm::dvec3& edges) {
  if (options.kernel != field::ResampleKernel::linear) return "the options choose a kernel";
  if (options.resolution && format != volume_io::VolumeFileFormat::vdb) return "the options set the number of samples";
  if (!is_close(edges.y, edges.x) || !is_close(edges.z, edges.x)) return "the new voxels are not cubic";
  if (!has_perpendicular_axes(index_to_world)) return "the axes are not perpendicular";
  return "";
}

}  // namespace

Result<std::optional<field::ScalarField>> rebuild_level_set(const SourceOptions& options,
                                                            volume_io::VolumeFileFormat format,
                                                            const field::ScalarField& field, const Context& context,
                                                            Events& events) {
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  const bool is_narrow_band =
      sparse != nullptr && field.kind == field::FieldKind::level_set && !options.read.kind && sparse->background > 0;
  if (!is_narrow_band || (options.resolution && glm::any(glm::lessThan(*options.resolution, glm::ivec3(2))))) return {};
  const Stopwatch watch;
  const field::Affine lattice = requested_lattice(options, field);
  const glm::dvec3 edges = edges_of(field.index_to_world.after(lattice));
  const std::string label = field_label(field);
  if (const std::string why = why_interpolated(options, format, field.index_to_world, edges); !why.empty()) {
    events.note({NoteId::level_set_interpolated,
                 fmt::format("{}: resampling interpolates the level set, because {}: its narrow band ends {:.3g} new "
                             "voxels from the surface",
                             label, why, sparse->background / std::max({edges.x, edges.y, edges.z}))});
    return {};
  }
  if (is_close(lattice.linear[0].x, 1) && is_close(lattice.linear[1].y, 1) && is_close(lattice.linear[2].z, 1)) {
    events.end(report_on_field(StageName::resample, label,
                               {WorkTopic::resolution, WorkDone::left_out, std::nullopt, std::nullopt,
                                "resampling, because the data has the requested resolution"},
                               watch.elapsed()));
    return field;
  }
  auto rebuilt = TRY(volume_io::rebuild_level_set(field, lattice, kHalfBand, context));
  TRY(volume_io::check_mapping_intact(field));
  if (options.voxel_size) {  // without the rounding of the scale
    const glm::dvec3 before = edges_of(field.index_to_world);
    for (int axis = 0; axis < 3; ++axis) {
      rebuilt.index_to_world.linear[axis] =
          field.index_to_world.linear[axis] / before[axis] * (*options.voxel_size)[axis];
    }
  }
  const std::uint64_t voxels = std::get<field::SparseSamples>(rebuilt.samples).active_voxels;
  events.end(
      report_on_field(StageName::resample, label,
                      {WorkTopic::resolution, WorkDone::resampled, voxels, std::nullopt,
                       fmt::format("the level set, with voxels of {:.6g} and a band of {:g} voxels on either side: {}",
                                   edges.x, kHalfBand, counted(voxels, "active voxel"))},
                      watch.elapsed()));
  return rebuilt;
}

}  // namespace isoextract::convert

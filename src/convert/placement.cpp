#include "convert/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "convert/field_label.hpp"

namespace isoextract::convert {
namespace {

constexpr std::array kUnits{LengthUnit{"um", 1},  LengthUnit{"mm", 1e3},    LengthUnit{"cm", 1e4},
                            LengthUnit{"m", 1e6}, LengthUnit{"in", 25'400}, LengthUnit{"ft", 304'800}};
constexpr std::size_t kMetre = 3;

constexpr double kVoxelTolerance = 1e-6;
constexpr double kAxisTolerance = 1e-6;  // of an axis' length

// The field's extents in world or voxel coordinates.
field::Box bounds_in(const field::ScalarField& field, Space space) {
  const field::IndexBox extents = field.extents();
  return field::image_of(space == Space::index ? field.index_to_file : field.index_to_world,
                         {glm::dvec3(extents.min), glm::dvec3(extents.max)});
}

// The signs of x and y in RAS coordinates, by what the file calls its world; none where that is no anatomical space.
// NIfTI's name stands in nifti_reader.cpp; NRRD's are those of its format definition, and may end in "-time".
std::optional<glm::dvec2> ras_signs(std::string_view world_space) {
  if (world_space.starts_with("RAS") || world_space.starts_with("right-anterior-superior")) return glm::dvec2(1, 1);
  if (world_space.starts_with("LAS") || world_space.starts_with("left-anterior-superior")) return glm::dvec2(-1, 1);
  if (world_space.starts_with("LPS") || world_space.starts_with("left-posterior-superior")) return glm::dvec2(-1, -1);
  return std::nullopt;
}

// Mirrors the axes of the field's world; nothing where its space is not known.
std::optional<field::Affine> anatomical_map(std::string_view world_space, AnatomicalSpace to) {
  const auto from = ras_signs(world_space);
  if (!from) return std::nullopt;
  const glm::dvec2 signs = to == AnatomicalSpace::ras ? *from : -*from;
  return field::scaling(glm::dvec3(signs, 1));
}

// Where samples are: sparse ones are everywhere, for the background is a value like any other.
field::IndexBox sample_box(const field::ScalarField& field) {
  if (std::holds_alternative<field::DenseSamples>(field.samples)) return field.extents();
  return {glm::ivec3(-field::kMaxSparseIndex), glm::ivec3(field::kMaxSparseIndex)};
}

}  // namespace

std::span<const LengthUnit> length_units() { return kUnits; }
const LengthUnit& metre() { return kUnits[kMetre]; }

double unit_ratio(const LengthUnit& from, const LengthUnit& to) { return from.micrometres / to.micrometres; }

field::Affine output_from_index(const field::ScalarField& field, const Placement& placement) {
  if (placement.space == Space::index) return field.index_to_file;
  field::Affine map = field::scaling(glm::dvec3(placement.scale)).after(field.index_to_world);
  if (placement.to_space) {
    if (const auto mirrored = anatomical_map(field.world_space, *placement.to_space)) map = mirrored->after(map);
  }
  if (placement.turn_z_up_to_y_up)
    map = field::Affine{glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(0)}.after(map);
  if (placement.turn_y_up_to_z_up)
    map = field::Affine{glm::dmat3(1, 0, 0, 0, 0, 1, 0, -1, 0), glm::dvec3(0)}.after(map);
  return map;
}

field::Box world_bounds(const field::ScalarField& field) { return bounds_in(field, Space::world); }

bool is_axis_aligned(const field::Affine& index_to_world) {
  for (int column = 0; column < 3; ++column) {
    const glm::dvec3 axis = glm::abs(index_to_world.linear[column]);
    const double longest = std::max({axis.x, axis.y, axis.z});
    if (axis.x + axis.y + axis.z - longest > kAxisTolerance * longest) return false;
  }
  return true;
}

Result<field::IndexBox> samples_in_box(const field::ScalarField& field, const field::Box& box, Space space,
                                       bool covering) {
  const field::Affine& map = space == Space::index ? field.index_to_file : field.index_to_world;
  const field::Box wanted = field::image_of(map.inverse(), box);
  const field::IndexBox stored = sample_box(field);
  const glm::dvec3 first(stored.min);
  const glm::dvec3 last(stored.max);
  field::IndexBox samples;
  for (int axis = 0; axis < 3; ++axis) {
    // Clipped as doubles: the box may reach further than an int.
    const double low =
        covering ? std::floor(wanted.min[axis] + kVoxelTolerance) : std::ceil(wanted.min[axis] - kVoxelTolerance);
    const double high =
        covering ? std::ceil(wanted.max[axis] - kVoxelTolerance) : std::floor(wanted.max[axis] + kVoxelTolerance);
    samples.min[axis] = static_cast<int>(std::clamp(low, first[axis], last[axis] + 1));
    samples.max[axis] = static_cast<int>(std::clamp(high, first[axis] - 1, last[axis]));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (samples.max[axis] - samples.min[axis] >= 1) continue;
    return fail(ErrorKind::input,
                fmt::format("{}: the region {} holds fewer than two samples along {}; the data is at {}", field.source,
                            box_text(box), "xyz"[axis], box_text(bounds_in(field, space))),
                space == Space::index ? Remedy::region_is_in_voxels : Remedy::region_is_in_world);
  }
  return samples;
}

Result<PlacedField> place_field(const field::ScalarField& field, const Placement& placement,
                                const std::optional<field::Box>& roi, bool closed) {
  if (placement.to_space && !ras_signs(field.world_space)) {
    const std::string found = field.world_space.empty() ? "does not say" : fmt::format("says '{}'", field.world_space);
    return fail(ErrorKind::usage,
                fmt::format("{}: {} was asked for, which needs a file that says whether its world is RAS, LAS or LPS; "
                            "this one {}",
                            field_label(field), word_of(*placement.to_space), found),
                "NIfTI files always say it, and NRRD files by their space");
  }
  PlacedField placed;
  placed.output_from_index = output_from_index(field, placement);
  if (field.index_to_world.is_regular() && !placed.output_from_index.is_regular()) {
    return fail(
        ErrorKind::usage,
        fmt::format("{}: scaled by {}, coordinates leave the range of numbers", field_label(field), placement.scale),
        Remedy::choose_scale);
  }
  if (!roi) return placed;
  const bool oblique = placement.space == Space::world && !is_axis_aligned(field.index_to_world);
  placed.cut_at_box = oblique && !closed;
  auto region = samples_in_box(field, *roi, placement.space, placed.cut_at_box);
  if (!region) return tl::unexpected(region.error());
  placed.region = *region;
  if (oblique) {
    const glm::i64vec3 dims = region->dims();
    placed.notes.push_back(
        closed ? fmt::format("{}: its axes are oblique, so the region is the {} x {} x {} samples that cover the box: "
                             "a surface is closed along samples",
                             field_label(field), dims.x, dims.y, dims.z)
               : fmt::format("{}: its axes are oblique, so the surface of the {} x {} x {} samples that cover the box "
                             "is cut at it",
                             field_label(field), dims.x, dims.y, dims.z));
  }
  return placed;
}

std::string box_text(const field::Box& box) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) .. ({:.6g}, {:.6g}, {:.6g})", box.min.x, box.min.y, box.min.z, box.max.x,
                     box.max.y, box.max.z);
}

}  // namespace isoextract::convert

#include "convert/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/number_text.hpp"
#include "base/printable.hpp"
#include "convert/field_label.hpp"

namespace isoextract::convert {
namespace {

constexpr std::array kUnits{LengthUnit{"angstrom", 1e2}, LengthUnit{"nm", 1e3},    LengthUnit{"um", 1e6},
                            LengthUnit{"mm", 1e9},       LengthUnit{"cm", 1e10},   LengthUnit{"m", 1e12},
                            LengthUnit{"in", 25.4e9},    LengthUnit{"ft", 304.8e9}};
constexpr std::size_t kMeter = 5;

// Names of units in files, with ASCII letters in lower case and without the plural s. Unicode has two micro signs.
constexpr std::array<std::pair<std::string_view, std::string_view>, 20> kOtherNames{
    {{"å", "angstrom"},    {"Å", "angstrom"},    {"nanometer", "nm"},  {"nanometre", "nm"},  {"µm", "um"},
     {"μm", "um"},         {"micron", "um"},     {"micrometer", "um"}, {"micrometre", "um"}, {"millimeter", "mm"},
     {"millimetre", "mm"}, {"centimeter", "cm"}, {"centimetre", "cm"}, {"meter", "m"},       {"metre", "m"},
     {"inch", "in"},       {"inche", "in"},      {"\"", "in"},         {"foot", "ft"},       {"feet", "ft"}}};

constexpr std::size_t kMaxShownUnit = 80;  // characters of the file's text shown in messages

constexpr double kVoxelTolerance = 1e-6;
constexpr double kAxisTolerance = 1e-6;  // relative to the axis length

// Returns the field's extents in world or voxel coordinates.
field::Box bounds_in(const field::ScalarField& field, Space space) {
  const field::IndexBox extents = field.extents();
  return field::image_of(request_from_index(field, space), {glm::dvec3(extents.min), glm::dvec3(extents.max)});
}

// Returns the signs of x and y that convert the file's world to RAS, or nullopt if it is no anatomical space. The names
// come from nifti_reader.cpp and from the NRRD format definition, in which they may end in "-time".
std::optional<glm::dvec2> ras_signs(std::string_view world_space) {
  if (world_space.starts_with("RAS") || world_space.starts_with("right-anterior-superior")) return glm::dvec2(1, 1);
  if (world_space.starts_with("LAS") || world_space.starts_with("left-anterior-superior")) return glm::dvec2(-1, 1);
  if (world_space.starts_with("LPS") || world_space.starts_with("left-posterior-superior")) return glm::dvec2(-1, -1);
  return std::nullopt;
}

// Returns the box of all samples. A sparse field has no bounds: samples outside the blocks have the background value.
field::IndexBox sample_box(const field::ScalarField& field) {
  if (std::holds_alternative<field::DenseSamples>(field.samples)) return field.extents();
  return {glm::ivec3(-field::kMaxSparseIndex), glm::ivec3(field::kMaxSparseIndex)};
}

// Returns the placement with the unit that the file states, if kFileUnit was requested.
Result<Placement> with_unit_of_file(const field::ScalarField& field, const Placement& placement) {
  Placement with_unit = placement;
  if (placement.unit != kFileUnit) return with_unit;
  const auto unit = find_length_unit(field.length_unit);
  if (!unit && field.length_unit.empty()) {
    return fail(ErrorCode::placement, fmt::format("{}: the file states no unit of length", field_label(field)),
                {Remedy::give, Setting::unit});
  }
  if (!unit) {
    return fail(ErrorCode::placement,
                fmt::format("{}: expected a known unit of length in the file, found '{}'", field_label(field),
                            printable(field.length_unit, kMaxShownUnit)),
                {Remedy::give, Setting::unit});
  }
  const auto to = placement.to_unit.empty() ? unit : find_length_unit(placement.to_unit);
  with_unit.unit = unit->name;
  with_unit.to_unit = to->name;
  with_unit.scale = unit_ratio(*unit, *to);
  return with_unit;
}

// Returns `map` followed by the placement's scale, mirroring and turn, but not ResolvedPlacement::moved_by.
field::Affine placed_after(const field::Affine& map, const ResolvedPlacement& resolved) {
  const Placement& placement = resolved.placement;
  field::Affine placed = field::scaling(glm::dvec3(placement.scale)).after(map);
  if (placement.to_space) placed = field::scaling(glm::dvec3(resolved.signs, 1)).after(placed);
  if (placement.turn_z_up_to_y_up)
    placed = field::Affine{glm::dmat3(1, 0, 0, 0, 0, -1, 0, 1, 0), glm::dvec3(0)}.after(placed);
  if (placement.turn_y_up_to_z_up)
    placed = field::Affine{glm::dmat3(1, 0, 0, 0, 0, 1, 0, -1, 0), glm::dvec3(0)}.after(placed);
  return placed;
}

}  // namespace

std::span<const LengthUnit> length_units() { return kUnits; }
const LengthUnit& meter() { return kUnits[kMeter]; }

std::optional<LengthUnit> find_length_unit(std::string_view text) {
  std::string name = to_lower(std::string(text));
  const auto unit_called = [](std::string_view wanted) -> std::optional<LengthUnit> {
    const auto found = std::ranges::find(kUnits, wanted, &LengthUnit::name);
    return found == kUnits.end() ? std::nullopt : std::optional(*found);
  };
  if (const auto unit = unit_called(name)) return unit;
  if (name.ends_with('s')) name.pop_back();
  const auto other = std::ranges::find(kOtherNames, name, &std::pair<std::string_view, std::string_view>::first);
  return unit_called(other == kOtherNames.end() ? std::string_view(name) : other->second);
}

double unit_ratio(const LengthUnit& from, const LengthUnit& to) { return from.picometers / to.picometers; }

std::optional<UpAxis> up_axis_of(std::string_view creator) {
  return creator.starts_with("Houdini") ? std::optional(UpAxis::y) : std::nullopt;
}

field::Affine ResolvedPlacement::output_from_world() const {
  field::Affine map = placed_after({}, *this);
  map.offset += moved_by;
  return map;
}

const field::Affine& request_from_index(const field::ScalarField& field, Space space) {
  return space == Space::index ? field.index_to_file : field.index_to_world;
}

std::optional<field::Affine> map_between_worlds(const field::ScalarField& from, const field::ScalarField& to) {
  glm::dvec3 factors(1);
  if (const auto of_from = ras_signs(from.world_space), of_to = ras_signs(to.world_space); of_from && of_to) {
    factors = glm::dvec3(*of_from * *of_to, 1);
  }
  if (const auto of_from = find_length_unit(from.length_unit), of_to = find_length_unit(to.length_unit);
      of_from && of_to) {
    factors *= unit_ratio(*of_from, *of_to);
  }
  if (factors == glm::dvec3(1)) return std::nullopt;
  return field::scaling(factors);
}

double front_azimuth(const field::ScalarField& field, const ResolvedPlacement& placement) {
  const auto signs = placement.placement.space == Space::world ? ras_signs(field.world_space) : std::nullopt;
  return signs && signs->y * placement.signs.y > 0 ? 180 : 0;
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
  const field::Affine& map = request_from_index(field, space);
  const field::Box wanted = field::image_of(map.inverse(), box);
  const field::IndexBox stored = sample_box(field);
  const glm::dvec3 first(stored.min);
  const glm::dvec3 last(stored.max);
  field::IndexBox samples;
  for (int axis = 0; axis < 3; ++axis) {
    // Clamped as doubles, because the box may exceed the range of int.
    const double low =
        covering ? std::floor(wanted.min[axis] + kVoxelTolerance) : std::ceil(wanted.min[axis] - kVoxelTolerance);
    const double high =
        covering ? std::ceil(wanted.max[axis] - kVoxelTolerance) : std::floor(wanted.max[axis] + kVoxelTolerance);
    samples.min[axis] = static_cast<int>(std::clamp(low, first[axis], last[axis] + 1));
    samples.max[axis] = static_cast<int>(std::clamp(high, first[axis] - 1, last[axis]));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (samples.max[axis] - samples.min[axis] >= 1) continue;
    return fail(
        ErrorCode::input,
        fmt::format("{}: the region {} contains {} along {}; the data extend over {}", field.source, box_text(box),
                    covering ? "no cell of the data" : "fewer than two samples", "xyz"[axis],
                    box_text(bounds_in(field, space))),
        {Remedy::check, Setting::region,
         space == Space::index ? "the region is in voxel coordinates, as the mesh is"
                               : "the region is in the world coordinates of the input, not in mesh coordinates"});
  }
  return samples;
}

namespace {

// Returns the faces of a box as planes, lower and upper face of each axis in turn.
std::vector<ClipPlane> faces_of(const field::Box& box) {
  std::vector<ClipPlane> faces;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 normal(0);
    normal[axis] = 1;
    faces.push_back({normal, box.min[axis]});
    faces.push_back({-normal, -box.max[axis]});
  }
  return faces;
}

// Returns the faces of `roi` that lie inside the region but not on a sample plane. The sample axes are parallel to
// those of `roi`. Reduces `kept` to the part of the region inside `roi`, in index coordinates.
std::vector<ClipPlane> faces_between_samples(const field::Affine& request_from_index, const field::Box& roi,
                                             field::Box& kept) {
  const field::Box wanted = field::image_of(request_from_index.inverse(), roi);
  const std::vector<ClipPlane> faces = faces_of(roi);
  std::vector<ClipPlane> cuts;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 along = request_from_index.linear[axis];
    const glm::dvec3 length = glm::abs(along);
    const int across = length.x >= length.y && length.x >= length.z ? 0 : length.y >= length.z ? 1 : 2;
    const std::size_t lower = 2 * static_cast<std::size_t>(across) + (along[across] < 0 ? 1 : 0);
    if (wanted.min[axis] > kept.min[axis] + kVoxelTolerance) {
      kept.min[axis] = wanted.min[axis];
      cuts.push_back(faces[lower]);
    }
    if (wanted.max[axis] < kept.max[axis] - kVoxelTolerance) {
      kept.max[axis] = wanted.max[axis];
      cuts.push_back(faces[lower ^ 1]);
    }
  }
  return cuts;
}

// Sets the region of `placed` and its cuts. Returns the part of the samples that is kept, in index coordinates; with
// oblique axes all samples that cover `roi`.
Result<field::Box> take_region(const field::ScalarField& field, const field::Box& roi, RegionEnds ends,
                               PlacedField& placed) {
  const Space space = placed.placement.placement.space;
  const field::Affine& map = request_from_index(field, space);
  const bool oblique = !is_axis_aligned(map);
  const auto covering = TRY(samples_in_box(field, roi, space, true));
  const auto box_of = [](const field::IndexBox& box) { return field::Box{glm::dvec3(box.min), glm::dvec3(box.max)}; };
  placed.region = covering;
  field::Box kept = box_of(covering);
  const glm::i64vec3 cover = covering.dims();
  if (oblique) {
    const bool cuts = ends == RegionEnds::faces;
    if (cuts) placed.cuts = faces_of(roi);
    placed.notes.push_back(
        {NoteId::region_at_samples,
         cuts
             ? fmt::format(
                   "{}: the sample axes are oblique to the region, so the conversion extracts the {} x {} x {} samples "
                   "that cover the region, and clips the surface at its faces",
                   field_label(field), cover.x, cover.y, cover.z)
             : fmt::format(
                   "{}: the sample axes are oblique to the region, so surfaces end at the {} x {} x {} samples that "
                   "cover the region",
                   field_label(field), cover.x, cover.y, cover.z)});
    return kept;
  }
  std::vector<ClipPlane> between = faces_between_samples(map, roi, kept);
  if (ends == RegionEnds::faces) {
    placed.cuts = std::move(between);
    return kept;
  }
  if (between.empty()) return kept;
  const auto within = TRY(samples_in_box(field, roi, space));
  placed.region = within;
  const glm::i64vec3 dims = within.dims();
  placed.notes.push_back(
      {NoteId::region_at_samples,
       fmt::format("{}: the faces of the region lie between samples, so surfaces end at the {} x {} x {} samples "
                   "inside the region",
                   field_label(field), dims.x, dims.y, dims.z)});
  return box_of(within);
}

}  // namespace

Result<PlacedField> place_field(const field::ScalarField& field, const Placement& placement,
                                const std::optional<field::Box>& roi, RegionEnds ends) {
  if (placement.to_space && !ras_signs(field.world_space)) {
    const std::string found = field.world_space.empty() ? "states none" : fmt::format("states '{}'", field.world_space);
    return fail(ErrorCode::placement,
                fmt::format("{}: the anatomical space {} needs a file that states RAS, LAS or LPS world coordinates; "
                            "this file {}",
                            field_label(field), word_of(*placement.to_space), found),
                "use a NIfTI file, or an NRRD file with the field 'space'");
  }
  auto with_unit = TRY(with_unit_of_file(field, placement));
  PlacedField placed;
  ResolvedPlacement& resolved = placed.placement;
  resolved.placement = std::move(with_unit);
  if (placement.to_space) {
    const glm::dvec2 from = *ras_signs(field.world_space);
    resolved.signs = *placement.to_space == AnatomicalSpace::ras ? from : -from;
  }
  placed.output_from_index =
      placement.space == Space::index ? field.index_to_file : placed_after(field.index_to_world, resolved);
  if (field.index_to_world.is_invertible() && !placed.output_from_index.is_invertible()) {
    return fail(ErrorCode::placement,
                fmt::format("{}: with the scale {}, coordinates or voxel volumes leave the range of 64-bit floats",
                            field_label(field), resolved.placement.scale),
                {Remedy::change, Setting::scale});
  }
  const field::IndexBox samples = field.extents();
  field::Box kept{glm::dvec3(samples.min), glm::dvec3(samples.max)};
  if (roi) {
    kept = TRY(take_region(field, *roi, ends, placed));
  }
  if (placement.center && (roi || !samples.empty())) {
    const glm::dvec3 middle = 0.5 * (kept.min + kept.max);
    resolved.moved_by = -placed.output_from_index(middle);
    placed.output_from_index.offset += resolved.moved_by;
  }
  return placed;
}

std::string box_text(const field::Box& box) {
  return fmt::format("{} .. {}", point_text(box.min), point_text(box.max));
}

}  // namespace isoextract::convert

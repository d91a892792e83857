// Placement: the transform from sample indices to output coordinates. Also finds the samples in a box.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Coordinates of regions, clip planes and the output. index: voxel coordinates (ScalarField::index_to_file), for which
// place_field() applies no scale, mirroring or turn.
enum class Space { world, index };
constexpr auto words_of(Space /*type*/) { return std::array{Word{Space::world, "world"}, Word{Space::index, "index"}}; }

enum class UpAxis { y, z };
constexpr auto words_of(UpAxis /*type*/) { return std::array{Word{UpAxis::y, "y"}, Word{UpAxis::z, "z"}}; }
// Returns the up axis of the program that wrote a file, by the creator name in the file; nullopt if unknown.
[[nodiscard]] std::optional<UpAxis> up_axis_of(std::string_view creator);

// Coordinate systems of medical scans: x to the patient's right or left, y to anterior or posterior, z superior.
enum class AnatomicalSpace { ras, lps };
constexpr auto words_of(AnatomicalSpace /*type*/) {
  return std::array{Word{AnatomicalSpace::ras, "ras"}, Word{AnatomicalSpace::lps, "lps"}};
}

struct LengthUnit {
  std::string_view name;
  double picometers;  // a whole number, so that unit ratios are rounded only once
};
[[nodiscard]] std::span<const LengthUnit> length_units();
[[nodiscard]] const LengthUnit& meter();
// Finds a unit by a name that files use: "mm", "millimeters", "Microns", ...
[[nodiscard]] std::optional<LengthUnit> find_length_unit(std::string_view text);

// Returns the factor that converts lengths from unit `from` to unit `to`.
[[nodiscard]] double unit_ratio(const LengthUnit& from, const LengthUnit& to);

// Placement::unit with this value means the unit that the file states.
inline constexpr std::string_view kFileUnit = "file";

// The requested transform from sample indices to the coordinates in the output file.
struct Placement {
  Space space = Space::world;
  UpAxis up = UpAxis::z;           // up axis of the input's world
  bool turn_z_up_to_y_up = false;  // (x, y, z) -> (x, z, -y)
  bool turn_y_up_to_z_up = false;  // (x, y, z) -> (x, -z, y); never both turns
  double scale = 1;                // place_field() finds the scale if the unit is kFileUnit
  std::string unit;                // unit of the input's world, or kFileUnit; empty if none was given
  // Unit of the output, which `scale` converts to; empty if `unit` is empty, or to keep the file's unit.
  std::string to_unit;
  std::optional<AnatomicalSpace> to_space;  // mirrors the world's axes into this space, before the turn
  // Moves the center of the region (without a region: of the field's extents) to the origin, after all other steps.
  // The command line refuses it with Space::index.
  bool center = false;

  friend bool operator==(const Placement&, const Placement&) = default;
};

// A placement whose open values are resolved for one field.
struct ResolvedPlacement {
  Placement placement;       // with the actual unit in place of kFileUnit, and its scale
  glm::dvec2 signs{1.0};     // factors of x and y for Placement::to_space
  glm::dvec3 moved_by{0.0};  // shift for Placement::center, in output coordinates

  // Returns the map from the input's world (in Space::index: from voxel coordinates) to output coordinates.
  [[nodiscard]] field::Affine output_from_world() const;

  friend bool operator==(const ResolvedPlacement&, const ResolvedPlacement&) = default;
};

// Returns the map from sample indices to the coordinates of regions and clip planes: world coordinates, or voxel
// coordinates for Space::index.
[[nodiscard]] const field::Affine& request_from_index(const field::ScalarField& field, Space space);

// Returns the map from the world of `from` to the world of `to`: mirrors axes if both name a patient space (RAS, LAS or
// LPS), scales if both state a known length unit. Returns nullopt if nothing changes.
[[nodiscard]] std::optional<field::Affine> map_between_worlds(const field::ScalarField& from,
                                                              const field::ScalarField& to);

// Returns the azimuth in degrees from which the output shows the front of a patient: 180 if +y is anterior, as in RAS,
// else 0. It is 0 for fields without a patient space (RAS, LAS or LPS) and for Space::index.
[[nodiscard]] double front_azimuth(const field::ScalarField& field, const ResolvedPlacement& placement);

// Returns the field's extents in world coordinates.
[[nodiscard]] field::Box world_bounds(const field::ScalarField& field);

// Returns whether every sample axis is parallel to a world axis.
[[nodiscard]] bool is_axis_aligned(const field::Affine& index_to_world);

// A half-space to keep: the points p with dot(normal, p) >= offset.
struct ClipPlane {
  static constexpr std::array kMembers{"normal", "offset"};

  glm::dvec3 normal{0, 0, 1};  // any length but 0
  double offset = 0;

  friend bool operator==(const ClipPlane&, const ClipPlane&) = default;
};

// How surfaces end at the region's boundary.
enum class RegionEnds {
  faces,  // at the faces of the box: surfaces are cut at faces between samples, or at all faces if axes are oblique
  // At samples: keeps the samples inside the region, or with oblique sample axes the samples that cover it.
  samples,
};

// Returns the smallest index box that holds all samples of `field` in `box`. With `covering`, the box that holds all
// cells that `box` touches. `box` is in world or voxel coordinates, as `space` says; the tolerance is 1e-6 voxels.
// Fails with ErrorCode::input if the result is less than one cell of the data.
[[nodiscard]] Result<field::IndexBox> samples_in_box(const field::ScalarField& field, const field::Box& box,
                                                     Space space, bool covering = false);

// A field's placement in the output, and its region.
struct PlacedField {
  ResolvedPlacement placement;
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  // Faces of the requested box at which surfaces are to be cut, in the coordinates of the box.
  std::vector<ClipPlane> cuts;
  Notes notes;  // about how the region was fitted to the samples
};

// Resolves the placement and the region, which `roi` gives in the coordinates of Placement::space. Adds a note if the
// sample axes are oblique to the region, or if surfaces end at samples instead of the region's faces.
//
// Fails with ErrorCode::placement if to_space is set and the file states no RAS, LAS or LPS space, or if the unit is
// kFileUnit and the file states no known unit. Fails with the same code if the scale makes the field's transform
// singular. Fails as samples_in_box() does.
[[nodiscard]] Result<PlacedField> place_field(const field::ScalarField& field, const Placement& placement,
                                              const std::optional<field::Box>& roi, RegionEnds ends);

// Returns "(0, 0, 0) .. (1, 2, 3)".
[[nodiscard]] std::string box_text(const field::Box& box);

}  // namespace isoextract::convert

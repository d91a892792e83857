// Where the mesh goes: from samples to output coordinates, and from a world box to samples.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

enum class Space { world, index };
constexpr auto words_of(Space /*type*/) { return std::array{Word{Space::world, "world"}, Word{Space::index, "index"}}; }

enum class UpAxis { y, z };
constexpr auto words_of(UpAxis /*type*/) { return std::array{Word{UpAxis::y, "y"}, Word{UpAxis::z, "z"}}; }
// The axis that points up in what a program makes, by the name that its files give; none where that is not known.
[[nodiscard]] std::optional<UpAxis> up_axis_of(std::string_view creator);

// The axes that scans of bodies are stored in: x to the right or the left, y to the front or the back, z to the head.
enum class AnatomicalSpace { ras, lps };
constexpr auto words_of(AnatomicalSpace /*type*/) {
  return std::array{Word{AnatomicalSpace::ras, "ras"}, Word{AnatomicalSpace::lps, "lps"}};
}

struct LengthUnit {
  std::string_view name;
  double picometres;  // a whole number, so that ratios of units are rounded once
};
[[nodiscard]] std::span<const LengthUnit> length_units();
[[nodiscard]] const LengthUnit& metre();
// The unit that files call so: "mm", "millimeters", "Microns", ...
[[nodiscard]] std::optional<LengthUnit> find_length_unit(std::string_view text);

// What lengths in `from` are multiplied by to be in `to`.
[[nodiscard]] double unit_ratio(const LengthUnit& from, const LengthUnit& to);

// In place of a unit's name: the one that the file states.
inline constexpr std::string_view kUnitOfFile = "file";

// What happens between the samples' indices and the coordinates in the file.
struct Placement {
  Space space = Space::world;
  UpAxis up = UpAxis::z;                    // of the input's world
  bool turn_z_up_to_y_up = false;           // (x, y, z) -> (x, z, -y)
  bool turn_y_up_to_z_up = false;           // (x, y, z) -> (x, -z, y); not both
  double scale = 1;                         // for place_field() to find with kUnitOfFile
  std::string unit;                         // of the input's world, or kUnitOfFile; empty if none was named
  std::string to_unit;                      // that `scale` converts it to; empty with `unit`, or to stay in the file's
  std::optional<AnatomicalSpace> to_space;  // that the world's axes are mirrored into, before they are turned
  bool center = false;  // last, the middle of the samples is moved to the origin: of the region, or else of the field's
                        // extents; not in Space::index

  friend bool operator==(const Placement&, const Placement&) = default;
};

// The same where the field is known.
struct ResolvedPlacement {
  Placement placement;       // with the unit in place of kUnitOfFile, and its scale
  glm::dvec2 signs{1.0};     // that x and y are multiplied by, for Placement::to_space
  glm::dvec3 moved_by{0.0};  // for Placement::center, in output coordinates

  // From the input's world, or from voxel coordinates in Space::index, to the output.
  [[nodiscard]] field::Affine output_from_world() const;

  friend bool operator==(const ResolvedPlacement&, const ResolvedPlacement&) = default;
};

// To the coordinates that regions and planes are given in.
[[nodiscard]] const field::Affine& given_from_index(const field::ScalarField& field, Space space);

// From the world of one field to that of another, where both say which patient space they are in (RAS, LAS or LPS), or
// both state units of length: mirrored axes, other units. Nothing where the worlds are the same or a field does not
// say.
[[nodiscard]] std::optional<field::Affine> map_between_worlds(const field::ScalarField& from,
                                                              const field::ScalarField& to);

// The field's extents in world coordinates.
[[nodiscard]] field::Box world_bounds(const field::ScalarField& field);

// True if every axis of the samples runs along an axis of the world.
[[nodiscard]] bool is_axis_aligned(const field::Affine& index_to_world);

// Which part of a surface is kept: the points p with dot(normal, p) >= offset.
struct ClipPlane {
  static constexpr std::array kMembers{"normal", "offset"};

  glm::dvec3 normal{0, 0, 1};  // of any length but 0
  double offset = 0;

  friend bool operator==(const ClipPlane&, const ClipPlane&) = default;
};

// Where the surfaces of a region end.
enum class RegionEnds {
  faces,    // at the faces of its box: surfaces are cut there where no sample is on a face
  samples,  // at samples: the region is the box of those within it; oblique to it, of those that cover it
};

// The samples of `field` in `box` (world or voxel coordinates, as `space` says), to a millionth of a voxel: the
// smallest index box that holds them all; or, `covering` the box, that holds all cells that it touches. Fails with
// ErrorCode::input if that is less than one cell of the data.
[[nodiscard]] Result<field::IndexBox> samples_in_box(const field::ScalarField& field, const field::Box& box,
                                                     Space space, bool covering = false);

// A field's place in the output, and what of it is wanted.
struct PlacedField {
  ResolvedPlacement placement;
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::vector<ClipPlane> cuts;     // faces of the box asked for within the region, where surfaces are to be cut
  std::vector<std::string> notes;  // what of the box asked for could not be taken as it is
};

// A region is a box in the coordinates of Placement::space. A note tells where it ends at samples that are not on its
// faces. Fails with ErrorCode::usage where an anatomical space or a unit is asked for and the file does not say which
// one its world is, where the scale leads out of the range of numbers, and as samples_in_box does.
[[nodiscard]] Result<PlacedField> place_field(const field::ScalarField& field, const Placement& placement,
                                              const std::optional<field::Box>& roi, RegionEnds ends);

// "(0, 0, 0) .. (1, 2, 3)"
[[nodiscard]] std::string box_text(const field::Box& box);

}  // namespace isoextract::convert

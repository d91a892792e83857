// Where the mesh goes: from samples to output coordinates, and from a world box to samples.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "cli/values.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

enum class Space { world, index };
enum class UpAxis { y, z };

struct LengthUnit {
  std::string_view name;
  double metres;
};
[[nodiscard]] std::span<const LengthUnit> length_units();

// What happens between the samples' indices and the coordinates in the file.
struct Placement {
  Space space = Space::world;
  UpAxis up = UpAxis::z;           // of the input's world
  bool turn_z_up_to_y_up = false;  // (x, y, z) -> (x, z, -y)
  double scale = 1;
  std::string_view unit;  // that `scale` converts to metres; empty if none was named
};

[[nodiscard]] field::Affine output_from_index(const field::ScalarField& field, const Placement& placement);

// "world coordinates, turned from z up to y up, scaled by 0.001 (mm to m)"
[[nodiscard]] std::string describe(const Placement& placement);

// The field's extents in world coordinates.
[[nodiscard]] field::Box world_bounds(const field::ScalarField& field);

// True if every axis of the samples runs along an axis of the world.
[[nodiscard]] bool is_axis_aligned(const field::Affine& index_to_world);

// The samples of `field` in `box` (world or voxel coordinates, as `space` says), to a millionth of a voxel. Where the
// samples' axes are oblique, the smallest index box that holds them all. Fails with ErrorKind::input if that is less
// than one cell of the data.
[[nodiscard]] Result<field::IndexBox> samples_in_box(const field::ScalarField& field, const field::Box& box,
                                                     Space space);

// A field's place in the output, and what of it is wanted.
struct PlacedField {
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::vector<std::string> notes;  // what --roi took that was not asked for
};

// Fails with ErrorKind::usage where --scale or --unit leads out of the range of numbers, and as samples_in_box does.
[[nodiscard]] Result<PlacedField> place_field(const field::ScalarField& field, const Placement& placement,
                                              const std::optional<field::Box>& roi);

// "(0, 0, 0) .. (1, 2, 3)"
[[nodiscard]] std::string box_text(const field::Box& box);

}  // namespace isoextract::cli

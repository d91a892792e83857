// The columns of the automaton as scalar fields: volumes that surfaces are extracted from, and maps of heights.
//
// Volumes: z points up, and each of `spacing`, the voxels are as large as cells: voxel (x, y, k) is the cube of cell
// (x, y) between the heights k and k + 1, and its sample, in its middle, is the part of it that is filled, 0 to 1 in
// f32. Inside is above: at iso value 0.5 a surface passes within half a voxel of the heights, and voxels above 0.5 are
// there for who draws them as cubes. Water stands on the terrain, and together they fill no more than 1. The corner of
// the grid is at the world's origin.
#pragma once

#include <array>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/words.hpp"
#include "field/scalar_field.hpp"
#include "simulate/water.hpp"

namespace isoextract::simulate {

enum class WaterContent {
  water,
  terrain,
  both,     // a volume each
  heights,  // the terrain's height and the water's depth in cells, f64, as two maps of one layer
};
constexpr auto words_of(WaterContent /*type*/) {
  return std::array{Word{WaterContent::water, "water"}, Word{WaterContent::terrain, "terrain"},
                    Word{WaterContent::both, "both"}, Word{WaterContent::heights, "heights"}};
}

// The names of the fields, in their order.
[[nodiscard]] std::vector<std::string> field_names(WaterContent content);

// Layers of voxels that hold land and water, and an empty one above, so that surfaces close below the top. Fails with
// ErrorCode::output where the numbers are infinite, or more layers than a volume has.
[[nodiscard]] Result<int> layers_for(const WaterAutomaton& automaton);

// One field or two. `layers` is of volumes; land and water above them would be cut off, which is an error of the
// caller. Cells with a depth below 0 (of the printed rule) are empty in volumes; maps have the numbers as they are.
// Fails as MemoryBudget::reserve() does.
[[nodiscard]] Result<std::vector<field::ScalarField>> water_fields(const WaterAutomaton& automaton,
                                                                   WaterContent content, int layers,
                                                                   const glm::dvec3& spacing, const Context& context);

}  // namespace isoextract::simulate

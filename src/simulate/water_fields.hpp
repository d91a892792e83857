// Turns the columns of the automaton into scalar fields: volumes for surface extraction, and height maps.
//
// In volumes z points up and voxels have the size of cells, `spacing`. Voxel (x, y, k) is the cube of cell (x, y)
// between heights k and k + 1. Its sample, at the center, is the filled fraction, 0 to 1 in f32. Inside is above: at
// iso value 0.5 the surface is within half a voxel of the true heights, but water at most one voxel deep may have no
// surface. Water stands on the terrain; together they fill at most 1. A corner of the grid is at the world's origin.
#pragma once

#include <array>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "simulate/water.hpp"

namespace isoextract::simulate {

enum class WaterOutput {
  water,
  terrain,
  both,  // one volume each
  // Terrain height and water depth in cells, f64, as two maps with one layer.
  heights,
};
constexpr auto words_of(WaterOutput /*type*/) {
  return std::array{Word{WaterOutput::water, "water"}, Word{WaterOutput::terrain, "terrain"},
                    Word{WaterOutput::both, "both"}, Word{WaterOutput::heights, "heights"}};
}

// Returns the names of the fields that water_fields() returns, in that order: terrain before water.
[[nodiscard]] std::vector<std::string> field_names(WaterOutput content);

// Returns the number of voxel layers that contain land and water, plus an empty one, so that surfaces close below the
// top. Fails with ErrorCode::output if a depth or energy is not finite, or if land or water is 2^16 cells high or
// higher.
[[nodiscard]] Result<int> count_layers(const WaterAutomaton& automaton);

// Returns one field or two. `layers` (see count_layers()) applies to volumes, which end there: higher parts are
// missing. Cells with a negative depth (of the printed rule) have no water in volumes; maps contain the numbers
// unchanged. Fails as MemoryBudget::reserve() does.
[[nodiscard]] Result<std::vector<field::ScalarField>> water_fields(const WaterAutomaton& automaton, WaterOutput content,
                                                                   int layers, const glm::dvec3& spacing,
                                                                   const Context& context);

}  // namespace isoextract::simulate

// Hilly land around a basin, from three-dimensional Perlin noise. It is made once, before the first step, because it
// does not change (paper on the water automaton, section 2.1.2; see water.hpp).
#pragma once

#include <cstdint>
#include <memory>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::simulate {

inline constexpr int kMaxGridSize = 1 << 15;  // cells along an axis

struct TerrainOptions {
  glm::ivec2 size{96, 96};  // cells along x and y; 2 to kMaxGridSize each
  std::uint64_t seed = 1;
  double relief = 24;  // highest minus lowest cell, in cells; 0 (flat) or more
  int octaves = 5;     // octaves of noise; 1 to 16
};

// The middle of the basin, as a fraction of the size: where the land would be lowest without hills.
inline constexpr glm::dvec2 kBasin{0.68, 0.5};

// The height of the lowest cell above the floor of the world, in cells.
inline constexpr double kMinLandHeight = 1;
// Returns the height of each cell above the floor of the world, in cells, from kMinLandHeight to kMinLandHeight +
// relief; cell (x, y) is element x + size.x * y. Fails with ErrorCode::usage for options out of range, and as
// MemoryBudget::reserve() does.
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<double>>> make_terrain(const TerrainOptions& options,
                                                                           const Context& context);

}  // namespace isoextract::simulate

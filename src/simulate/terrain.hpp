// Hilly land around a basin, from three-dimensional Perlin noise, as the paper of the water's automaton makes it: once,
// for it does not change (water.hpp names the paper; its section 2.1.2).
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
  double relief = 24;  // how far the highest cell is above the lowest, in cells; 0 or more: 0 is flat
  int octaves = 5;     // of the noise; 1 to 16
};

// Where the land is lowest, as a part of its size: the middle of the basin.
inline constexpr glm::dvec2 kBasin{0.68, 0.5};

// The height of each cell above the floor of the world, from kLowestLand to kLowestLand + relief: that of cell (x, y)
// is element x + size.x * y. Fails with ErrorCode::usage for options outside of what they say, and as
// MemoryBudget::reserve() does.
inline constexpr double kLowestLand = 1;
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<double>>> make_terrain(const TerrainOptions& options,
                                                                           const Context& context);

}  // namespace isoextract::simulate

// Sets of bricks as sorted lists of their places: (x, y, z) counts bricks, not samples. Bricks are those of
// field::SparseBlock, 8 samples a side. Moving a whole list keeps its order, so neighbours are found by merging lists;
// there is no table, and memory follows the bricks.
#pragma once

#include <memory>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::points {

using BrickList = std::shared_ptr<ReservedBuffer<glm::ivec3>>;

// x first, then y, then z.
[[nodiscard]] inline bool brick_before(const glm::ivec3& a, const glm::ivec3& b) {
  if (a.x != b.x) return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}

// All of these fail as Context::reserve() does; `label` names the particles then.

// Those of `bricks` for which keep(number) holds.
template <class F>
[[nodiscard]] Result<BrickList> chosen_bricks(std::span<const glm::ivec3> bricks, const F& keep, const Context& context,
                                              const std::string& label) {
  std::size_t count = 0;
  for (std::size_t b = 0; b < bricks.size(); ++b) count += static_cast<std::size_t>(keep(b));
  auto chosen = make_reserved_buffer<glm::ivec3>(count, context, label);
  if (!chosen) return chosen;
  glm::ivec3* out = (*chosen)->values.data();
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    if (keep(b)) *out++ = bricks[b];
  }
  return chosen;
}

// Every brick that is at most `rings` away from one of `bricks` along each axis. Fails where the context is cancelled,
// too.
[[nodiscard]] Result<BrickList> dilated(std::span<const glm::ivec3> bricks, int rings, const Context& context,
                                        const std::string& label);

// Those of `bricks` whose 26 neighbours are all among `bricks`.
[[nodiscard]] Result<BrickList> eroded(std::span<const glm::ivec3> bricks, const Context& context,
                                       const std::string& label);

}  // namespace isoextract::points

// Sets of bricks as sorted lists of brick coordinates (x, y, z): sample coordinates divided by 8, the side of
// field::SparseBlock. Translating a whole list keeps its order, so merging two lists finds neighbors without a hash
// table, and memory grows with the number of bricks.
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

// Compares by x, then y, then z.
[[nodiscard]] inline bool brick_before(const glm::ivec3& a, const glm::ivec3& b) {
  if (a.x != b.x) return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}

// The functions below fail as Context::reserve() does; `label` names the particles in the message.

// Returns the bricks for which keep(index) holds.
template <class F>
[[nodiscard]] Result<BrickList> bricks_if(std::span<const glm::ivec3> bricks, const F& keep, const Context& context,
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

// Returns every brick at most `rings` bricks away from one of `bricks` along each axis. Also fails if the context is
// cancelled.
[[nodiscard]] Result<BrickList> dilated(std::span<const glm::ivec3> bricks, int rings, const Context& context,
                                        const std::string& label);

// Returns the bricks whose 26 neighbors are all in `bricks`.
[[nodiscard]] Result<BrickList> eroded(std::span<const glm::ivec3> bricks, const Context& context,
                                       const std::string& label);

}  // namespace isoextract::points

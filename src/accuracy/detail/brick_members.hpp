// Groups members of a mesh by bricks of cells, for work that visits mesh and field brick by brick.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include <tbb/parallel_sort.h>
#include <glm/glm.hpp>

#include "base/parallel.hpp"

namespace isoextract::accuracy {

struct BrickMember {
  glm::ivec3 brick{0};
  std::uint32_t id = 0;

  [[nodiscard]] auto order() const { return std::tuple(brick.z, brick.y, brick.x, id); }
};

// Returns members with the numbers below `count`, sorted by brick. list_bricks(i, add) calls add(brick) once for each
// brick of member i; it must add the same bricks when called again.
template <class ListBricks>
[[nodiscard]] std::vector<BrickMember> members_by_brick(std::size_t count, const ListBricks& list_bricks) {
  constexpr std::size_t kGrain = 1 << 12;
  std::atomic<std::size_t> listed{0};
  for_each_range(count, kGrain, [&](std::size_t begin, std::size_t end) {
    std::size_t here = 0;
    for (std::size_t i = begin; i != end; ++i) list_bricks(i, [&](const glm::ivec3& /*brick*/) { ++here; });
    listed += here;
  });
  std::vector<BrickMember> members(listed.load());
  std::atomic<std::size_t> next{0};
  for_each_range(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      list_bricks(i, [&](const glm::ivec3& brick) { members[next++] = {brick, static_cast<std::uint32_t>(i)}; });
    }
  });
  tbb::parallel_sort(members.begin(), members.end(),
                     [](const BrickMember& a, const BrickMember& b) { return a.order() < b.order(); });
  return members;
}

// Returns the members of one brick; `members` come from members_by_brick().
[[nodiscard]] inline std::span<const BrickMember> members_of(const std::vector<BrickMember>& members,
                                                             const glm::ivec3& brick) {
  const auto key = [](const BrickMember& member) { return std::tuple(member.brick.z, member.brick.y, member.brick.x); };
  const std::tuple wanted(brick.z, brick.y, brick.x);
  return {std::ranges::lower_bound(members, wanted, {}, key), std::ranges::upper_bound(members, wanted, {}, key)};
}

// A brick, and the number of isosurface triangles in it.
struct BrickCount {
  glm::ivec3 brick{0};
  std::uint64_t triangles = 0;
};

// Sorts the bricks (by z, then y, then x) and merges duplicates, adding their counts.
inline void merge_bricks(std::vector<BrickCount>& bricks) {
  const auto key = [](const BrickCount& one) { return std::tuple(one.brick.z, one.brick.y, one.brick.x); };
  tbb::parallel_sort(bricks.begin(), bricks.end(),
                     [&](const BrickCount& a, const BrickCount& b) { return key(a) < key(b); });
  std::size_t kept = 0;
  for (std::size_t b = 0; b < bricks.size(); ++b) {
    if (kept > 0 && bricks[kept - 1].brick == bricks[b].brick) {
      bricks[kept - 1].triangles += bricks[b].triangles;
    } else {
      bricks[kept++] = bricks[b];
    }
  }
  bricks.resize(kept);
}

}  // namespace isoextract::accuracy

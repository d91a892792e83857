// Lists the triangles that a round of collapses divides into patches.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/parallel.hpp"
#include "edit/detail/collapse_state.hpp"

namespace isoextract::edit {

inline constexpr std::size_t kTriangleGrain = 1 << 13;  // of parallel loops over triangles

// A triangle, and the grid cell that is its patch.
struct PatchTriangle {
  std::uint64_t cell;
  std::uint32_t triangle;
};

// Returns the remaining triangles whose corners satisfy `holds`, in their order, all in cell 0. Several threads call
// `holds` at once.
template <class Holds>
[[nodiscard]] std::vector<PatchTriangle> remaining_triangles(const CollapseState& state, const Holds& holds) {
  const std::size_t triangles = state.corners.size();
  const std::size_t ranges = (triangles + kTriangleGrain - 1) / kTriangleGrain;
  const auto for_each_of_range = [&](std::size_t range, const auto& body) {
    const std::size_t end = std::min((range + 1) * kTriangleGrain, triangles);
    for (std::size_t t = range * kTriangleGrain; t < end; ++t) {
      if (state.gone[t] == 0 && holds(state.corners[t])) body(static_cast<std::uint32_t>(t));
    }
  };
  std::vector<std::size_t> first(ranges + 1, 0);  // of each range: the position of its first triangle; and the end
  for_each_index(ranges, [&](std::size_t r) {
    std::size_t count = 0;
    for_each_of_range(r, [&](std::uint32_t) { ++count; });
    first[r + 1] = count;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<PatchTriangle> list(first.back());
  for_each_index(ranges, [&](std::size_t r) {
    std::size_t next = first[r];
    for_each_of_range(r, [&](std::uint32_t t) { list[next++] = {0, t}; });
  });
  return list;
}

struct CornerBox {
  glm::dvec3 low{std::numeric_limits<double>::infinity()};
  glm::dvec3 high{-std::numeric_limits<double>::infinity()};
};

// Returns the box around the first corner of each triangle.
[[nodiscard]] inline CornerBox box_of_first_corners(const CollapseState& state,
                                                    std::span<const PatchTriangle> triangles) {
  return reduce_ranges(
      triangles.size(), kTriangleGrain, CornerBox(),
      [&](std::size_t begin, std::size_t end, CornerBox box) {
        for (const PatchTriangle& listed : triangles.subspan(begin, end - begin)) {
          const glm::dvec3 p(state.positions[state.corners[listed.triangle].x]);
          box = {glm::min(box.low, p), glm::max(box.high, p)};
        }
        return box;
      },
      [](const CornerBox& a, const CornerBox& b) {
        return CornerBox{glm::min(a.low, b.low), glm::max(a.high, b.high)};
      });
}

}  // namespace isoextract::edit

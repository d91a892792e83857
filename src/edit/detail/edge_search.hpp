// Finds the triangles on the other side of edges.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "edit/detail/sheet_trees.hpp"

namespace isoextract::edit {

// Holds a linked list of the triangles around each vertex, by the numbers of their corners.
class EdgeSearch {
 public:
  // Skips the triangles whose entry in `left_out` is not 0. Needs fewer than 2^32 / 3 triangles. Keeps references
  // to `triangles` and `sheets`. Throws std::bad_alloc.
  EdgeSearch(std::span<const glm::uvec3> triangles, std::size_t vertices, std::span<const char> left_out,
             const Sheets& sheets)
      : triangles_(triangles), sheets_(sheets), first_(vertices, kNoCorner), next_(triangles.size()) {
    for (auto t = static_cast<std::uint32_t>(triangles.size()); t-- > 0;) {
      if (left_out[t] != 0) continue;
      for (std::uint32_t corner = 0; corner < 3; ++corner) {
        std::uint32_t& list = first_[triangles[t][static_cast<int>(corner)]];
        next_[t][corner] = list;
        list = 3 * t + corner;
      }
    }
  }

  // Calls visit(triangle, corner, other) for each corner at a vertex, of which an edge runs to the next corner. `other`
  // is the triangle of the sheet that runs along this edge in the opposite direction. It is empty if there is none, if
  // several run along the edge in one direction, or if a triangle has a corner twice. So if A is across an edge of B, B
  // is across this edge of A. Takes time by d log d for d triangles at the vertex.
  template <class Visit>
  void for_each_across(std::uint32_t vertex, const Visit& visit) const {
    constexpr std::size_t kMany = 16;
    std::array<Around, kMany> around;
    std::size_t count = 0;
    for (std::uint32_t at = first_[vertex]; at != kNoCorner; at = next_[at / 3][at % 3]) {
      if (count == kMany) return for_each_across_of_many(vertex, visit);
      around[count++] = around_of(at);
    }
    const auto find = [&](std::size_t i) -> std::optional<std::uint32_t> {
      std::optional<std::uint32_t> other;
      for (std::size_t j = 0; j < count; ++j) {
        if (around[j].sheet != around[i].sheet) continue;
        if (j != i && around[j].next == around[i].next) return std::nullopt;
        if (around[j].previous != around[i].next) continue;
        if (other || around[j].corner / 3 == around[i].corner / 3) return std::nullopt;
        other = around[j].corner / 3;
      }
      return other;
    };
    for (std::size_t i = 0; i < count; ++i) visit(around[i].corner / 3, around[i].corner % 3, find(i));
  }

 private:
  static constexpr std::uint32_t kNoCorner = std::numeric_limits<std::uint32_t>::max();

  // A corner at a vertex, and the corners before and after it.
  struct Around {
    std::uint32_t corner, next, previous, sheet;
  };
  [[nodiscard]] Around around_of(std::uint32_t corner) const {
    return {corner, neighbor(corner, 1), neighbor(corner, 2), sheets_.of(corner / 3)};
  }

  template <class Visit>
  void for_each_across_of_many(std::uint32_t vertex, const Visit& visit) const {
    const auto by_next = [](const Around& a) { return std::pair(a.sheet, a.next); };
    const auto by_previous = [](const Around& a) { return std::pair(a.sheet, a.previous); };
    std::vector<Around> out;
    for (std::uint32_t at = first_[vertex]; at != kNoCorner; at = next_[at / 3][at % 3]) out.push_back(around_of(at));
    std::vector<Around> in = out;
    std::ranges::sort(out, {}, by_next);
    std::ranges::sort(in, {}, by_previous);
    for (const Around& a : out) {
      const auto same = std::ranges::upper_bound(out, by_next(a), {}, by_next) -
                        std::ranges::lower_bound(out, by_next(a), {}, by_next);
      const auto first = std::ranges::lower_bound(in, by_next(a), {}, by_previous);
      const auto opposite = std::ranges::upper_bound(in, by_next(a), {}, by_previous) - first;
      const bool is_pair = same == 1 && opposite == 1 && first->corner / 3 != a.corner / 3;
      visit(a.corner / 3, a.corner % 3, is_pair ? std::optional(first->corner / 3) : std::nullopt);
    }
  }

  // Returns the vertex that follows a corner of a triangle by so many steps.
  [[nodiscard]] std::uint32_t neighbor(std::uint32_t corner, std::uint32_t steps) const {
    return triangles_[corner / 3][static_cast<int>((corner % 3 + steps) % 3)];
  }

  std::span<const glm::uvec3> triangles_;
  const Sheets& sheets_;
  std::vector<std::uint32_t> first_;           // for each vertex: 3 * triangle + corner
  Buffer<std::array<std::uint32_t, 3>> next_;  // for each corner
};

}  // namespace isoextract::edit

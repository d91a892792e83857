// Finds the triangles that run along edges in a given direction.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
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

  // Returns the first triangle of a sheet that runs from one vertex to another. Walks the lists of both at once, and
  // ends with the shorter one: a vertex of very many triangles costs no more than its neighbors. Adds the number of
  // visited corners to `visited`.
  [[nodiscard]] std::optional<std::uint32_t> find_triangle(std::uint32_t from, std::uint32_t to, std::uint32_t sheet,
                                                           std::uint64_t* visited = nullptr) const {
    std::uint32_t at_from = first_[from];
    std::uint32_t at_to = first_[to];
    while (at_from != kNoCorner && at_to != kNoCorner) {
      if (visited != nullptr) *visited += 2;
      if (neighbor(at_from, 1) == to && sheets_.of(at_from / 3) == sheet) return at_from / 3;
      if (neighbor(at_to, 2) == from && sheets_.of(at_to / 3) == sheet) return at_to / 3;
      at_from = next_[at_from / 3][at_from % 3];
      at_to = next_[at_to / 3][at_to % 3];
    }
    return std::nullopt;
  }

  // Calls visit(triangle, corner, other) for each corner at a vertex, of which an edge runs to the next corner. `other`
  // is a triangle of the sheet that runs along this edge in the opposite direction, if there is one: the first around
  // the vertex, or what find_triangle() returns if the vertex has many triangles.
  template <class Visit>
  void for_each_across(std::uint32_t vertex, const Visit& visit) const {
    constexpr std::size_t kMany = 16;  // searches all pairs of fewer
    struct Around {
      std::uint32_t corner, next, previous;
    };
    std::array<Around, kMany> around;
    std::size_t count = 0;
    for (std::uint32_t at = first_[vertex]; at != kNoCorner && count < kMany; at = next_[at / 3][at % 3]) {
      around[count++] = {at, neighbor(at, 1), neighbor(at, 2)};
    }
    if (count == kMany) {
      for (std::uint32_t at = first_[vertex]; at != kNoCorner; at = next_[at / 3][at % 3]) {
        visit(at / 3, at % 3, find_triangle(neighbor(at, 1), vertex, sheets_.of(at / 3)));
      }
      return;
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::optional<std::uint32_t> other;
      for (std::size_t j = 0; j < count && !other; ++j) {
        if (around[j].previous != around[i].next) continue;
        if (sheets_.of(around[j].corner / 3) == sheets_.of(around[i].corner / 3)) other = around[j].corner / 3;
      }
      visit(around[i].corner / 3, around[i].corner % 3, other);
    }
  }

 private:
  static constexpr std::uint32_t kNoCorner = std::numeric_limits<std::uint32_t>::max();

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

// Bounds the distance of a triangle from a surface by heights above the triangle's plane, without a search.
//
// Projects the surface to the plane, and walks from triangle to triangle over all edges that divide the given triangle.
// If the walk meets no boundary and all its triangles face the same way, their projections cover the given one. If some
// face the other way or are upright, they cover it if their projected areas, with a sign, do not add up to 0. The
// distance at each of its points is then at most the height of the surface above the point. Heights are linear in each
// triangle of the surface, so they are greatest at corners. Where a height is too great, the distance from the triangle
// of the surface counts: it is a convex function, so it is greatest at corners, too.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "edit/detail/sheet_trees.hpp"
#include "mesh/distance_bound.hpp"

namespace isoextract::edit {

class SurfaceCover {
 public:
  // `slots` are SheetTrees::slots(); the trees were made of `triangles`, `left_out` and `sheets`. Keeps no reference.
  // Throws std::bad_alloc.
  SurfaceCover(const SheetTrees& trees, std::span<const std::uint32_t> slots, std::span<const glm::uvec3> triangles,
               std::size_t vertices, std::span<const char> left_out, const Sheets& sheets);

  // Bytes for each triangle that is not left out. The constructor takes as much again, and four for each vertex.
  static constexpr std::uint64_t kTriangleBytes = 3 * sizeof(std::uint32_t);

  // Bounds the distance of a triangle from a sheet. The upper end is at most `enough`, or it is infinite and the lower
  // end above `enough`. Returns nothing if the heights prove neither. `tree` is that of the sheet, and `slot` one of
  // its slots, preferably near the triangle's center. Computes in double and ignores rounding, as
  // mesh::bound_distance() does.
  [[nodiscard]] std::optional<mesh::TriangleBound> bound(const std::array<glm::dvec3, 3>& triangle,
                                                         const mesh::TriangleTree& tree, std::uint32_t sheet,
                                                         std::uint32_t slot, double enough) const;

 private:
  [[nodiscard]] const std::array<std::uint32_t, 3>& neighbors(std::uint32_t sheet, std::uint32_t slot) const {
    return neighbors_[first_[sheet] + slot];
  }

  std::vector<std::uint32_t> first_;  // of each sheet: the index in neighbors_ of its first slot
  // For each slot of each sheet: the slots across the edges that start at its corners, or the largest number at edges
  // that are not between two triangles. Empty if the mesh has too many triangles.
  Buffer<std::array<std::uint32_t, 3>> neighbors_;
};

}  // namespace isoextract::edit

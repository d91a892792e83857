// The sheets of a surface, and a tree of the triangles of each.
//
// The boundaries between labels are sheets: surfaces that meet in curves. Distances are measured within a sheet,
// because another sheet may be near where the original of the sheet is far away.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {

enum class VertexRole : std::uint8_t {
  free,
  kept,  // must stay
  // A vertex of a curve where a label touches itself. The label's mesh has several vertices there, one for each part
  // that touches. Each edge of the curve needs such a vertex at one end, or the parts would share the edge.
  touching,
};

// Does not own its data. By default all triangles are one sheet.
struct Sheets {
  std::span<const std::uint32_t> of_triangle = {};  // the number of each triangle's sheet; empty: all 0
  std::uint32_t count = 1;
  std::span<const VertexRole> roles = {};  // of each vertex; empty: all are free

  [[nodiscard]] std::uint32_t of(std::uint32_t triangle) const {
    return of_triangle.empty() ? 0 : of_triangle[triangle];
  }
};

class SheetTrees {
 public:
  // `left_out` has one entry for each triangle, nonzero if the trees leave it out. The trees are the same for any
  // number of threads. Throws std::bad_alloc.
  SheetTrees(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
             std::span<const char> left_out, const Sheets& sheets);

  // Returns null if all triangles of the sheet were left out.
  [[nodiscard]] const mesh::TriangleTree* find(std::uint32_t sheet) const {
    return trees_[sheet] ? &*trees_[sheet] : nullptr;
  }
  // Returns the tree of a sheet that has triangles.
  [[nodiscard]] const mesh::TriangleTree& tree(std::uint32_t sheet) const { return *trees_[sheet]; }
  // Returns the triangle in a slot of the tree of a sheet.
  [[nodiscard]] std::uint32_t triangle(std::uint32_t sheet, std::uint32_t slot) const {
    return numbers_[first_[sheet] + tree(sheet).triangle(slot)];
  }
  // Returns the slot of each triangle in the tree of its sheet; 0 for triangles left out. `triangles` counts all.
  [[nodiscard]] std::vector<std::uint32_t> slots(std::size_t triangles) const;

 private:
  std::vector<std::uint32_t> first_;    // of each sheet: the index in numbers_ of its first triangle; then the end
  std::vector<std::uint32_t> numbers_;  // of triangles, by sheet
  std::vector<std::optional<mesh::TriangleTree>> trees_;
};

}  // namespace isoextract::edit

// Counts the intersections of a few triangles of a mesh, before and after a change to them.
//
// A BoxTree finds the triangles nearby. It keeps its shape when triangles change; the boxes of its nodes grow. Tests
// are exact, as those of mesh/self_intersections.hpp, but count triangles with the same three corners as well.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/box_tree.hpp"
#include "mesh/mesh.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {

class PairCounter {
 public:
  struct Triangle {
    std::uint32_t number;
    glm::uvec3 corners;  // may differ from the mesh's corners of this triangle
  };

  // Keeps a reference to the mesh, which needs at least one triangle. The caller reserves bytes(). Throws
  // std::bad_alloc.
  explicit PairCounter(const mesh::Mesh& mesh);

  [[nodiscard]] static std::uint64_t bytes(const mesh::Mesh& mesh);

  [[nodiscard]] bool has_area(const glm::uvec3& corners) const;

  // Returns the number of intersections of these triangles with each other and with all triangles of other numbers.
  // Stops counting at `most`.
  [[nodiscard]] std::size_t count(std::span<const Triangle> triangles, std::size_t most) const;

  // Returns whether another vertex of the triangles has the position of `vertex`.
  [[nodiscard]] bool is_taken(std::uint32_t vertex) const;

  // Call it after each change to a triangle's corners or to their positions.
  void update(std::uint32_t number);

 private:
  [[nodiscard]] bool meet(const glm::uvec3& a, const glm::uvec3& b) const;
  [[nodiscard]] mesh::FloatBox box_of(const glm::uvec3& corners) const;
  [[nodiscard]] mesh::PlacedTriangle placed(const glm::uvec3& corners) const;
  [[nodiscard]] mesh::BoxTree tree_of_triangles() const;

  const mesh::Mesh& mesh_;
  mesh::BoxTree tree_;
  std::vector<std::uint32_t> slots_;  // the tree's slot of each triangle
};

}  // namespace isoextract::edit

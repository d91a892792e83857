// The zero surface of an interpolant in a box of cells, as triangles much smaller than the cells.
//
// Each cell that the surface may cross is divided into equal parts. Marching cubes on the interpolant's values at their
// corners gives the triangles. A trilinear interpolant is linear along the axes, so vertices lie on its surface;
// between them, the error falls with the square of the number of parts.
#pragma once

#include <cstdint>
#include <optional>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "field/interpolant.hpp"
#include "mesh/mesh.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {

struct Subdivision {
  field::FieldKind kind = field::FieldKind::density;
  glm::dmat3 linear{1.0};  // maps index steps to steps in the mesh's coordinates
  int parts = 2;           // parts of a cell along an axis; at least 2
};

class SubdividedSurface {
 public:
  // Builds the surface in `cells`, given by their lowest samples; all samples of the cells must be in the data. Skips
  // cells whose polynomial uses a non-finite sample. Fails as an extraction does.
  [[nodiscard]] static Result<SubdividedSurface> make(field::Interpolant::Cursor& field, const field::IndexBox& cells,
                                                      const Subdivision& how);

  // Returns the approximate memory of a surface and its tree, in a cube of `cells` cells along each axis. `triangles`
  // is the number of triangles if cells are not divided. The caller reserves this memory.
  [[nodiscard]] static std::uint64_t bytes(int cells, int parts, std::uint64_t triangles);

  [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }
  // Builds the tree on first use, so several threads must not call this at a time. Requires triangles.
  [[nodiscard]] const mesh::TriangleTree& tree();

  // Maps between index space and the coordinate frame of the positions and the tree.
  [[nodiscard]] glm::dvec3 local(const glm::dvec3& index) const { return linear_ * (index - anchor_) - mesh_.origin; }
  [[nodiscard]] glm::dvec3 index(const glm::dvec3& local) const {
    return index_from_local_ * (local + mesh_.origin) + anchor_;
  }

 private:
  SubdividedSurface(const glm::dvec3& anchor, const glm::dmat3& linear)
      : anchor_(anchor), linear_(linear), index_from_local_(glm::inverse(linear)) {}

  glm::dvec3 anchor_;
  glm::dmat3 linear_;
  glm::dmat3 index_from_local_;
  mesh::Mesh mesh_;
  std::optional<mesh::TriangleTree> tree_;
};

}  // namespace isoextract::accuracy

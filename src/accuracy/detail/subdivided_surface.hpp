// The surface where an interpolant is 0, within a box of cells, as triangles that are small beside the cells.
//
// Each cell that the surface may cross is divided into equal parts, and marching cubes on the interpolant's values at
// their corners gives the triangles. A trilinear interpolant is linear along the axes, so their vertices are on its
// surface; in between they are nearer to it than those of whole cells by the square of the number of parts.
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
  glm::dmat3 linear{1.0};  // index steps to steps in the mesh's coordinates
  int parts = 2;           // of a cell along an axis; at least 2
};

class SubdividedSurface {
 public:
  // `cells` holds the lowest samples of the cells; all of their samples are in the data. A cell whose polynomial
  // depends on a sample that is not finite has no surface. Fails as an extraction does.
  [[nodiscard]] static Result<SubdividedSurface> make(field::Interpolant::Cursor& field, const field::IndexBox& cells,
                                                      const Subdivision& how);

  // About what making one of so many cells along an axis takes, with its tree, where the cells have `triangles` as a
  // whole; the caller's to reserve.
  [[nodiscard]] static std::uint64_t bytes(int cells, int parts, std::uint64_t triangles);

  [[nodiscard]] const mesh::Mesh& mesh() const { return mesh_; }
  // Made on first use; only where there are triangles.
  [[nodiscard]] const mesh::TriangleTree& tree();

  // From index space into the frame of the positions and of the tree, and back.
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

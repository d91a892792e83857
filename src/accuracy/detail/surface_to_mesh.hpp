// Measures distances from points on the isosurface to a mesh.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <vector>

#include "accuracy/detail/search_window.hpp"
#include "accuracy/detail/subdivided_surface.hpp"
#include "accuracy/detail/surface_foot.hpp"
#include "accuracy/error_statistics.hpp"
#include "accuracy/index_mesh.hpp"
#include "field/interpolant.hpp"
#include "mesh/half_space.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {

using FieldFootFinder = FootFinder<field::Interpolant::Cursor>;

struct SurfaceToMeshSums {
  ErrorAccumulator distances;
  double at_most = 0;  // estimated upper bound for all points of the isosurface, in the mesh's units
  double needed = 0;   // distance within which the nearest points are, if the window is too small to find all; else 0

  void merge(const SurfaceToMeshSums& other) {
    distances.merge(other.distances);
    at_most = std::max(at_most, other.at_most);
    needed = std::max(needed, other.needed);
  }
};

class SurfaceToMesh {
 public:
  // `tree` contains the triangles of `mesh`, the part of the mesh in `window`; null: there are none. `placed` is `mesh`
  // in index space. `clipped` are the half-spaces that the mesh was clipped to.
  SurfaceToMesh(const mesh::Mesh& mesh, const mesh::TriangleTree* tree, const IndexMesh& placed,
                std::span<const mesh::HalfSpace> clipped, const SearchWindow& window);

  // Adds the distances of the triangles of `surface` whose centers `counts` accepts, weighted by area. Measures at the
  // vertices, and at the centers after moving them onto the isosurface. Points outside `clipped` do not count. Between
  // these points, at_most bounds the distance of each triangle's part within `clipped`. The bound is the smaller of
  // two. One is the distance to one triangle of the mesh, which is greatest at a corner of the part. The other is the
  // largest distance at a vertex plus the way to the nearest vertex. Adds the move of the center, for curvature.
  void measure(const SubdividedSurface& surface, FieldFootFinder& foot, double reach,
               const std::function<bool(const glm::dvec3& index)>& counts, SurfaceToMeshSums& sums) const;

 private:
  struct Sample {
    double weight = 0;
    double distance = 0;
    std::uint32_t slot = 0;
    bool used = false;
  };

  // Sets `polygon` to the part of `triangle` within the half-spaces, in the tree's frame. `before` is scratch memory.
  void clip(const std::array<glm::dvec3, 3>& triangle, std::vector<glm::dvec3>& polygon,
            std::vector<glm::dvec3>& before) const;
  [[nodiscard]] glm::dvec3 to_tree(const glm::dvec3& index) const { return linear_ * index + offset_; }
  mesh::TriangleTree::Nearest add(const glm::dvec3& index, double weight, std::uint32_t hint,
                                  SurfaceToMeshSums& sums) const;

  const mesh::TriangleTree* tree_;
  const IndexMesh& placed_;
  const SearchWindow& window_;
  std::span<const mesh::HalfSpace> clipped_;
  glm::dmat3 linear_;
  glm::dmat3 inverse_;
  glm::dvec3 origin_;  // of the mesh
  glm::dvec3 offset_;  // between index space and the frame of the tree
};

}  // namespace isoextract::accuracy

// Counts the components of an isosurface that comes in windows, and those that a mesh lacks.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "accuracy/detail/search_window.hpp"
#include "accuracy/index_mesh.hpp"
#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::accuracy {

// The isosurface in a window, extracted by Method::mc; with edge keys, unless it is the only window.
struct WindowSurface {
  const SearchWindow& window;
  const CellFinder& cells;
  const mesh::Mesh& mesh;
  const IndexMesh& placed;         // `mesh` in index space
  const mesh::TriangleTree* tree;  // of its triangles; null if there are none
};

// A component of one window continues in another one through vertices on the faces of their bricks. Edge keys identify
// these vertices.
class SurfaceComponents {
 public:
  // Counts only components with at least one vertex within all half-spaces of `kept`.
  explicit SurfaceComponents(std::span<const mesh::HalfSpace> kept) : kept_(kept) {}

  // Adds one window. `mesh` is the part of the mesh in the window. Call in the order of divide_bricks(). Returns 0, or
  // a distance within which the nearest component of a vertex can be found, if the window is too small for that; the
  // call then has no effect. The caller reserves bytes(). The object reserves what it keeps. `progress`, which may be
  // null, advances by the vertices of `mesh`. Fails with ErrorCode::out_of_memory. Throws std::bad_alloc.
  [[nodiscard]] Result<double> add(const WindowSurface& surface, const mesh::Mesh& mesh, const IndexMesh& placed,
                                   Progress* progress, const Context& context);

  // The mesh has vertices whose nearest component lies in the bricks of a window, but not of their own one. Returns the
  // first such window, with the margin that it was added with; null if there is none. mark_found() takes its surface.
  [[nodiscard]] const SearchWindow* unfinished() const;
  // Fails with ErrorCode::input if the surface differs from the one that add() got.
  [[nodiscard]] Result<void> mark_found(const WindowSurface& surface);

  struct Counts {
    std::uint64_t components = 0;
    std::uint64_t lost = 0;  // components that are nearest to no vertex of the mesh
  };
  // Returns the counts of all windows, once none is unfinished().
  [[nodiscard]] Counts counts();

  // Returns the memory that add() uses for an isosurface of this size.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices, std::uint64_t triangles) {
    return mesh::Components::bytes(vertices) + 3 * sizeof(std::uint32_t) * std::min(vertices, triangles);
  }

 private:
  struct HashOfEdge {
    [[nodiscard]] std::size_t operator()(const mesh::EdgeKey& edge) const;
  };
  struct Added {
    SearchWindow window;
    std::uint32_t first = 0;  // number of its first component that has triangles in its bricks
    std::uint32_t count = 0;  // of these components
  };
  // A surface triangle that is nearest to a vertex of the mesh, in bricks of another window: one of its vertices, and
  // its brick.
  struct Beyond {
    mesh::EdgeKey vertex;
    glm::ivec3 brick{0};
  };
  static constexpr std::uint32_t kNone = mesh::Components::kNone;

  // Returns the number of each component of the surface, from `first` on; kNone for those without triangles in the
  // window's bricks.
  [[nodiscard]] static std::vector<std::uint32_t> number(const WindowSurface& surface,
                                                         const mesh::Components& components, std::uint32_t first);
  void join_neighbors(const WindowSurface& surface, const mesh::Components& components,
                      std::span<const std::uint32_t> numbers);

  std::span<const mesh::HalfSpace> kept_;
  Reservation memory_;  // for all members
  std::vector<Added> windows_;
  // By component, over all windows: an earlier component that it belongs to, whether it counts, whether it was found.
  std::vector<std::uint32_t> parents_;
  std::vector<std::uint8_t> counted_;
  std::vector<std::uint8_t> found_;
  std::vector<Beyond> beyond_;
  // The numbers of components at vertices on faces of bricks that later windows may share.
  std::unordered_map<mesh::EdgeKey, std::uint32_t, HashOfEdge> on_faces_;
};

}  // namespace isoextract::accuracy

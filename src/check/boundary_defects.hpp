// Counts the defects of edges and vertices of each component, and finds the loops of open edges.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/topology.hpp"

namespace isoextract::check {

// The counts mean the same as in mesh::Topology.
struct EdgeDefects {
  std::uint64_t open = 0;
  std::uint64_t nonmanifold = 0;
  std::uint64_t misoriented = 0;
  std::uint64_t nonmanifold_vertices = 0;
};

// The rim of a hole: open edges connected through fans of triangles. A vertex with several fans counts as one vertex
// for each fan. At either end of a non-manifold edge, all triangles of the edge belong to one fan. Rims that share a
// fan count as one loop.
struct BoundaryLoop {
  std::uint64_t edges = 0;
  double length = 0;
  std::uint32_t component = 0;
};

struct BoundaryDefects {
  std::vector<EdgeDefects> components;  // one for each component
  std::vector<BoundaryLoop> loops;      // in the order of each loop's first edge; edges are sorted by vertex indices
};

// Finds the defects and loops of a mesh; `topology` and `components` must be the mesh's own. Fails with
// ErrorCode::out_of_memory if the working memory exceeds the budget: 32 bytes a component; if there are defects, also
// 24 bytes a triangle, 9 a vertex and 80 an open edge.
[[nodiscard]] Result<BoundaryDefects> find_boundary_defects(const mesh::Mesh& mesh, const mesh::Topology& topology,
                                                            const mesh::Components& components, const Context& context);

}  // namespace isoextract::check

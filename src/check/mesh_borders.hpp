// What is wrong with the edges and vertices of a mesh, component by component, and the loops of its open edges.
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"
#include "mesh/topology.hpp"

namespace isoextract::check {

// As in mesh::Topology.
struct EdgeDefects {
  std::uint64_t open = 0;
  std::uint64_t nonmanifold = 0;
  std::uint64_t misoriented = 0;
  std::uint64_t nonmanifold_vertices = 0;

  [[nodiscard]] bool none() const { return open + nonmanifold + misoriented + nonmanifold_vertices == 0; }
};

// Open edges that follow each other along one fan of triangles after the other: the rim of a hole. A vertex of several
// fans counts as several vertices, one a fan. Where an edge of three triangles or more ends on rims, they are one.
struct BorderLoop {
  std::uint64_t edges = 0;
  double length = 0;
  std::uint32_t component = 0;
};

struct MeshBorders {
  std::vector<EdgeDefects> components;  // of each
  std::vector<BorderLoop> loops;        // in the order of their edges with the lowest vertices
};

// `topology` and `components` are the mesh's. Fails where its working memory is more than is left: 24 bytes a triangle
// and 9 a vertex where there is anything wrong, and 64 an open edge.
[[nodiscard]] Result<MeshBorders> find_borders(const mesh::Mesh& mesh, const mesh::Topology& topology,
                                               const mesh::Components& components, const Context& context);

}  // namespace isoextract::check

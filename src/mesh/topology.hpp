// Facts of a mesh's connectivity, found from its indices alone (never by distance).
#pragma once

#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/components.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

struct Topology {
  std::uint64_t edges = 0;
  std::uint64_t open_edges = 0;            // used by one triangle
  std::uint64_t nonmanifold_edges = 0;     // used by more than two triangles
  std::uint64_t misoriented_edges = 0;     // used by two triangles that run along it in the same direction
  std::uint64_t nonmanifold_vertices = 0;  // whose triangles do not form one fan
  std::uint64_t unused_vertices = 0;
  std::uint64_t repeated_index_triangles = 0;  // with two equal indices
  std::uint64_t components = 0;
  std::int64_t euler = 0;  // vertices in use - edges + triangles

  // Not of a mesh without triangles, which closes nothing off.
  [[nodiscard]] bool is_closed_oriented_manifold() const {
    return edges > 0 && open_edges == 0 && nonmanifold_edges == 0 && misoriented_edges == 0 &&
           nonmanifold_vertices == 0 && repeated_index_triangles == 0;
  }
  // Of all components together, for closed meshes: euler = 2 * components - 2 * genus.
  [[nodiscard]] std::int64_t genus() const { return static_cast<std::int64_t>(components) - euler / 2; }
};

// Throws std::bad_alloc.
[[nodiscard]] Topology measure_topology(const Mesh& mesh);

// Fails where its working memory is more than is left: for large meshes some four bytes a triangle, a quarter of the
// mesh; for smaller ones up to 28.
[[nodiscard]] Result<Topology> measure_topology(const Mesh& mesh, const Context& context);

// Of each of the mesh's components by itself, in their order. Unused vertices and triangles that repeat an index are of
// none. Fails likewise; it takes some 70 bytes a component and thread besides.
[[nodiscard]] Result<std::vector<Topology>> measure_topology(const Mesh& mesh, const Components& components,
                                                             const Context& context);

}  // namespace isoextract::mesh

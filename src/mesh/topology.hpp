// Connectivity of a mesh, found from its indices alone (never by distance).
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
  std::uint64_t open_edges = 0;            // with one triangle
  std::uint64_t nonmanifold_edges = 0;     // with more than two triangles
  std::uint64_t misoriented_edges = 0;     // with two triangles that run along it in the same direction
  std::uint64_t nonmanifold_vertices = 0;  // their triangles form more than one fan
  std::uint64_t unused_vertices = 0;
  std::uint64_t repeated_index_triangles = 0;  // with two equal indices
  std::uint64_t components = 0;
  std::int64_t euler = 0;  // used vertices - edges + triangles without a repeated index

  // Returns false for a mesh without triangles, which encloses nothing.
  [[nodiscard]] bool is_closed_oriented_manifold() const {
    return edges > 0 && open_edges == 0 && nonmanifold_edges == 0 && misoriented_edges == 0 &&
           nonmanifold_vertices == 0 && repeated_index_triangles == 0;
  }
  // Returns the sum of the genera of all components, from euler = 2 * components - 2 * genus.
  // Requires is_closed_oriented_manifold().
  [[nodiscard]] std::int64_t genus() const { return static_cast<std::int64_t>(components) - euler / 2; }
};

// Throws std::bad_alloc.
[[nodiscard]] Topology measure_topology(const Mesh& mesh);

// Fails with ErrorCode::out_of_memory if its working memory exceeds the memory left. Needs 28 bytes per triangle for
// meshes below 262,144 vertices, and less for larger meshes: about 4 bytes per triangle from a million vertices on.
[[nodiscard]] Result<Topology> measure_topology(const Mesh& mesh, const Context& context);

// Returns the topology of each component in order. Unused vertices and triangles that repeat an index belong to none.
// Fails with ErrorCode::out_of_memory as above; needs about 70 bytes more for each component on each thread.
[[nodiscard]] Result<std::vector<Topology>> measure_topology(const Mesh& mesh, const Components& components,
                                                             const Context& context);

}  // namespace isoextract::mesh

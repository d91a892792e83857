// Finds the triangle on the other side of an edge.
#pragma once

#include <cstdint>
#include <optional>

#include "mesh/adjacency.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::edit {

// Returns the corner at which the edge from b to a starts; nothing if several triangles or none have this edge.
inline std::optional<mesh::Corner> find_corner_across(const mesh::Mesh& mesh, const mesh::Adjacency& around,
                                                      std::uint32_t a, std::uint32_t b) {
  std::optional<mesh::Corner> found;
  for (const mesh::Corner corner : around.corners(b)) {
    const glm::uvec3& t = mesh.triangles[mesh::triangle_of(corner)];
    if (t[static_cast<int>((corner % 3 + 1) % 3)] != a) continue;
    if (found) return std::nullopt;
    found = corner;
  }
  return found;
}

}  // namespace isoextract::edit

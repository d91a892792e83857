// Edges of intersecting triangles: the triangle on the other side, and the best change at one of them.
#pragma once

#include <array>
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

// Returns the change with the largest gain among change_at(triangle, corner) for all corners of the two triangles; the
// first of equal changes. Each change_at() may return nothing.
template <class ChangeAt>
auto best_of_pair(const std::array<std::uint32_t, 2>& pair, const ChangeAt& change_at) {
  decltype(change_at(pair[0], 0)) best;
  for (const std::uint32_t t : pair) {
    for (int corner = 0; corner < 3; ++corner) {
      const auto change = change_at(t, corner);
      if (change && (!best || change->gain > best->gain)) best = change;
    }
  }
  return best;
}

}  // namespace isoextract::edit

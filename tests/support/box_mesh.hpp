// Makes box meshes.
#pragma once

#include <algorithm>
#include <array>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::test {

// Returns a closed box, wound outward, with two triangles per side. In corner number n, bits 1, 2 and 4 select the high
// side along x, y and z.
inline mesh::Mesh box_mesh(const glm::vec3& low, const glm::vec3& high) {
  constexpr std::array<glm::uvec3, 12> kTriangles{{{0, 2, 1},
                                                   {1, 2, 3},
                                                   {4, 5, 6},
                                                   {5, 7, 6},
                                                   {0, 1, 4},
                                                   {1, 5, 4},
                                                   {2, 6, 3},
                                                   {3, 6, 7},
                                                   {0, 4, 2},
                                                   {2, 4, 6},
                                                   {1, 3, 5},
                                                   {3, 7, 5}}};
  mesh::Mesh mesh;
  mesh.positions = Buffer<glm::vec3>(8);
  for (unsigned n = 0; n < 8; ++n) {
    mesh.positions[n] = {(n & 1U) != 0 ? high.x : low.x, (n & 2U) != 0 ? high.y : low.y,
                         (n & 4U) != 0 ? high.z : low.z};
  }
  mesh.triangles = Buffer<glm::uvec3>(kTriangles.size());
  std::copy(kTriangles.begin(), kTriangles.end(), mesh.triangles.begin());
  return mesh;
}

}  // namespace isoextract::test

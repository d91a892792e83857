// Small meshes made by hand.
#pragma once

#include <algorithm>
#include <vector>

#include "mesh/mesh.hpp"

namespace isoextract::test {

inline mesh::Mesh make_mesh(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles) {
  mesh::Mesh mesh;
  mesh.positions = Buffer<glm::vec3>(positions.size());
  mesh.triangles = Buffer<glm::uvec3>(triangles.size());
  std::copy(positions.begin(), positions.end(), mesh.positions.begin());
  std::copy(triangles.begin(), triangles.end(), mesh.triangles.begin());
  return mesh;
}

// Corners 0, x, y, z of size 1; wound outward; volume 1/6.
inline mesh::Mesh tetrahedron() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

}  // namespace isoextract::test

// Small hand-made meshes.
#pragma once

#include <algorithm>
#include <random>
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

// Returns a tetrahedron with corners 0, x, y and z of size 1, wound outward; volume 1/6.
inline mesh::Mesh unit_tetrahedron() {
  return make_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}});
}

// Returns random triangles between nearby vertices. Some repeat an index, some occur twice, edges have any number of
// triangles in any direction, and some vertices are unused.
inline std::vector<glm::uvec3> random_triangles(std::size_t count, std::uint32_t vertices, unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<glm::uvec3> triangles(count);
  for (glm::uvec3& t : triangles) {
    const auto first = static_cast<std::uint32_t>(engine() % vertices);
    for (int c = 0; c < 3; ++c) t[c] = (first + static_cast<std::uint32_t>(engine() % 7)) % vertices;
  }
  return triangles;
}

}  // namespace isoextract::test

// Copies of meshes, unchanged or reordered as another backend would give them.
#pragma once

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "mesh/mesh.hpp"

namespace isoextract::test {

inline mesh::Mesh copy_of(const mesh::Mesh& mesh) { return copy(mesh); }

// Returns the mesh with vertices and triangles in random order and the corners of triangles rotated at random.
inline mesh::Mesh shuffled(const mesh::Mesh& mesh, unsigned seed) {
  std::mt19937 engine(seed);
  std::vector<std::uint32_t> number(mesh.positions.size());  // the new number of each vertex
  std::iota(number.begin(), number.end(), 0U);
  std::shuffle(number.begin(), number.end(), engine);
  mesh::Mesh result = copy_of(mesh);
  for (std::size_t v = 0; v < number.size(); ++v) {
    result.positions[number[v]] = mesh.positions[v];
    if (!mesh.normals.empty()) result.normals[number[v]] = mesh.normals[v];
    if (!mesh.edges.empty()) result.edges[number[v]] = mesh.edges[v];
  }
  for (glm::uvec3& t : result.triangles) {
    t = {number[t.x], number[t.y], number[t.z]};
    for (auto turns = engine() % 3; turns > 0; --turns) t = {t.y, t.z, t.x};
  }
  std::shuffle(result.triangles.begin(), result.triangles.end(), engine);
  return result;
}

// Returns a copy without one of the triangles.
inline mesh::Mesh without_triangle(const mesh::Mesh& mesh, std::size_t triangle) {
  mesh::Mesh result = copy_of(mesh);
  result.triangles = Buffer<glm::uvec3>(mesh.triangles.size() - 1);
  for (std::size_t t = 0, out = 0; t < mesh.triangles.size(); ++t) {
    if (t != triangle) result.triangles[out++] = mesh.triangles[t];
  }
  return result;
}

}  // namespace isoextract::test

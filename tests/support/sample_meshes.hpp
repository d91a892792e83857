// Small test meshes by formula.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/mesh.hpp"

namespace isoextract::test {

template <class T>
Buffer<T> buffer_of(const std::vector<T>& values) {
  Buffer<T> buffer(values.size());
  std::copy(values.begin(), values.end(), buffer.begin());
  return buffer;
}

inline mesh::Mesh make_mesh(std::string name, const std::vector<glm::vec3>& positions,
                            const std::vector<glm::uvec3>& triangles, const std::vector<glm::vec3>& normals = {},
                            const glm::dvec3& origin = glm::dvec3(0)) {
  mesh::Mesh mesh;
  mesh.name = std::move(name);
  mesh.origin = origin;
  mesh.positions = buffer_of(positions);
  mesh.normals = buffer_of(normals);
  mesh.triangles = buffer_of(triangles);
  return mesh;
}

// Returns a closed tetrahedron whose coordinates have no short decimal form.
inline mesh::Mesh tetrahedron(std::string name = "tetrahedron", const glm::dvec3& origin = glm::dvec3(0)) {
  return make_mesh(std::move(name), {{0.1F, -0.0F, 1e-7F}, {1.0F / 3, 0, 0}, {0, 1e6F / 7, 0}, {0, 0, -2.0F / 3}},
                   {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {3, 2, 1}}, {}, origin);
}

// Returns a closed unit sphere, wound outward, with rings * (2 * rings) vertices and two poles; with normals if
// requested.
inline mesh::Mesh sphere(unsigned rings, bool normals, std::string name = "sphere",
                         const glm::dvec3& origin = glm::dvec3(0)) {
  const unsigned columns = 2 * rings;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  positions.emplace_back(0, 0, 1);
  for (unsigned r = 0; r < rings; ++r) {
    const double polar = std::numbers::pi * (r + 1) / (rings + 1);
    for (unsigned c = 0; c < columns; ++c) {
      const double angle = 2 * std::numbers::pi * c / columns;
      positions.emplace_back(glm::normalize(
          glm::dvec3(std::sin(polar) * std::cos(angle), std::sin(polar) * std::sin(angle), std::cos(polar))));
    }
  }
  const unsigned south = static_cast<unsigned>(positions.size());
  positions.emplace_back(0, 0, -1);
  const auto vertex = [&](unsigned r, unsigned c) { return 1 + r * columns + c % columns; };
  for (unsigned c = 0; c < columns; ++c) {
    triangles.emplace_back(0, vertex(0, c), vertex(0, c + 1));
    for (unsigned r = 0; r + 1 < rings; ++r) {
      triangles.emplace_back(vertex(r, c), vertex(r + 1, c), vertex(r + 1, c + 1));
      triangles.emplace_back(vertex(r, c), vertex(r + 1, c + 1), vertex(r, c + 1));
    }
    triangles.emplace_back(vertex(rings - 1, c), south, vertex(rings - 1, c + 1));
  }
  return make_mesh(std::move(name), positions, triangles, normals ? positions : std::vector<glm::vec3>{}, origin);
}

}  // namespace isoextract::test

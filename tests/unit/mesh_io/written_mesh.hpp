// Shared by the tests of the mesh writers.
#pragma once

#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <vector>

#include "mesh_io/mesh_writer.hpp"
#include "unit/mesh_io/mesh_file_parsers.hpp"

namespace isoextract::test {

namespace fs = std::filesystem;

inline std::vector<mesh::Mesh> one(mesh::Mesh mesh) {
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(std::move(mesh));
  return meshes;
}

inline mesh_io::MeshWriteResult must_write(std::span<const mesh::Mesh> meshes, const fs::path& path,
                                           const mesh_io::MeshWriteOptions& options) {
  auto result = mesh_io::write_meshes(meshes, path, options, Context());
  if (!result) throw std::runtime_error(result.error().message);
  return std::move(*result);
}

// Compares bit for bit: -0 differs from 0.
template <class T>
bool same_values(const Buffer<T>& expected, const std::vector<T>& found) {
  return expected.size() == found.size() &&
         (expected.empty() || std::memcmp(expected.data(), found.data(), expected.size_bytes()) == 0);
}

inline bool same_local_positions(const mesh::Mesh& expected, const ParsedMesh& found) {
  const std::vector<glm::vec3> positions(found.positions.begin(), found.positions.end());
  return same_values(expected.positions, positions);
}

// Compares positions with the origin added.
inline bool same_positions(const mesh::Mesh& expected, const ParsedMesh& found) {
  if (expected.positions.size() != found.positions.size()) return false;
  for (std::size_t v = 0; v < found.positions.size(); ++v) {
    if (expected.position(v) != found.positions[v]) return false;
  }
  return true;
}

// Compares with face normals that are computed in another way than the writers compute them.
inline bool same_face_normals(const mesh::Mesh& expected, const std::vector<glm::vec3>& found) {
  if (expected.triangles.size() != found.size()) return false;
  for (std::size_t t = 0; t < found.size(); ++t) {
    const glm::uvec3 triangle = expected.triangles[t];
    const glm::dvec3 a = expected.positions[triangle.x];
    const glm::dvec3 b = expected.positions[triangle.y];
    const glm::dvec3 c = expected.positions[triangle.z];
    const glm::dvec3 sum = glm::cross(a, b) + glm::cross(b, c) + glm::cross(c, a);
    if (glm::length(glm::normalize(sum) - glm::dvec3(found[t])) > 1e-6) return false;
  }
  return true;
}

}  // namespace isoextract::test

#include "mesh_io/read/gltf_normals.hpp"

#include <fmt/format.h>

namespace isoextract::mesh_io {
namespace {

// Returns the matrix that transforms normals: the cofactor matrix of m, which equals m for a rotation; negated if m
// mirrors.
glm::dmat3 normal_matrix(const glm::dmat3& m) {
  const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
  return glm::determinant(m) < 0 ? -cofactors : cofactors;
}

// Transforms the direction and keeps the vector's length.
glm::vec3 turned(const glm::dmat3& matrix, const glm::dvec3& normal) {
  const glm::dvec3 there = matrix * normal;
  const double length = glm::length(there);
  return length > 0 ? glm::vec3(there / length * glm::length(normal)) : glm::vec3(0);
}

}  // namespace

void add_gltf_normals(GltfData& data, const nlohmann::json& attributes, std::uint64_t vertices, std::uint64_t triangles,
                      const PrimitiveCorners& corners, const Transform& transform, MemoryUse& memory,
                      FileSurfaceNormals& normals) {
  memory.make_room(normals.numbers, triangles);
  if (!attributes.contains("NORMAL")) {
    normals.numbers.insert(normals.numbers.end(), triangles, glm::uvec3(~std::uint32_t{0}));
    return;
  }
  const GltfView view = data.view(whole(attributes, "NORMAL"), "VEC3", 3);
  const bool is_short = view.component >= kGltfByte && view.component <= kGltfUnsignedShort;
  if (view.count != vertices || (view.component != kGltfFloat && !is_short)) {
    throw DamagedMesh(fmt::format(
        "expected {} normals of component type {} (float) or {} to {} (bytes, shorts), found {} normals of type {}",
        vertices, kGltfFloat, kGltfByte, kGltfUnsignedShort, view.count, view.component));
  }
  const std::uint64_t first = normals.values.size();
  require_vertex_count(first + vertices);
  memory.make_room(normals.values, vertices);
  const bool stays = transform.linear == glm::dmat3(1.0);
  const glm::dmat3 matrix = normal_matrix(transform.linear);
  for (std::uint64_t v = 0; v < vertices; ++v) {
    const glm::dvec3 normal = view.point(v);
    normals.values.push_back(stays ? glm::vec3(normal) : turned(matrix, normal));
  }
  for (std::uint64_t t = 0; t < triangles; ++t) {
    const auto [a, b, c] = corners(t);
    normals.numbers.emplace_back(first + a, first + b, first + c);
  }
}

}  // namespace isoextract::mesh_io

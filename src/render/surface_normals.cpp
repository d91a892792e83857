#include "render/surface_normals.hpp"

#include <cmath>

#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::render {
namespace {

// Returns the triangle's normal; its length is the angle at corner `c` in radians. Returns 0 for a triangle without
// area.
glm::dvec3 weighted_normal(const mesh::Mesh& mesh, const glm::uvec3& triangle, int c) {
  const glm::dvec3 at(mesh.positions[triangle[c]]);
  const glm::dvec3 next = glm::dvec3(mesh.positions[triangle[(c + 1) % 3]]) - at;
  const glm::dvec3 last = glm::dvec3(mesh.positions[triangle[(c + 2) % 3]]) - at;
  const glm::dvec3 across = glm::cross(next, last);
  const double length = glm::length(across);
  if (!(length > 0) || !std::isfinite(length)) return glm::dvec3(0);
  return across / length * std::atan2(length, glm::dot(next, last));
}

}  // namespace

Result<void> add_normals(mesh::Mesh& mesh, const std::string& source, const Context& context) {
  if (!mesh.normals.empty() || mesh.positions.empty()) return {};
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(context.reserve(vertices * sizeof(glm::vec3), source + ": normals"));
  const auto working = TRY(context.reserve(mesh::Adjacency::bytes(mesh.triangles.size(), vertices),
                                           source + ": the triangles around each vertex"));
  const mesh::Adjacency around(mesh.triangles.span(), vertices);
  Buffer<glm::vec3> normals(vertices);
  for_each_range(vertices, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      glm::dvec3 sum(0);
      for (const mesh::Corner corner : around.corners(v)) {
        sum += weighted_normal(mesh, mesh.triangles[mesh::triangle_of(corner)], static_cast<int>(corner % 3));
      }
      const double length = glm::length(sum);
      normals[v] = length > 0 ? glm::vec3(sum / length) : glm::vec3(0, 0, 1);
    }
  });
  mesh.normals = std::move(normals);
  mesh.memory.take(std::move(memory));
  return {};
}

}  // namespace isoextract::render

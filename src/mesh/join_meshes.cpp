#include "mesh/join_meshes.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace isoextract::mesh {

Result<Mesh> join_meshes(std::span<const Mesh> meshes, const Context& context) {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  for (const Mesh& mesh : meshes) {
    vertices += mesh.positions.size();
    triangles += mesh.triangles.size();
  }
  if (vertices > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input,
                fmt::format("{} meshes have {} vertices together; expected at most {}, the limit of one mesh",
                            meshes.size(), vertices, std::numeric_limits<std::uint32_t>::max()));
  }
  auto memory = TRY(context.reserve(vertices * sizeof(glm::vec3) + triangles * sizeof(glm::uvec3),
                                    fmt::format("{} meshes as one", meshes.size())));
  Mesh joined;
  joined.positions = Buffer<glm::vec3>(vertices);
  joined.triangles = Buffer<glm::uvec3>(triangles);
  joined.memory = std::move(memory);
  std::uint32_t first_vertex = 0;
  glm::uvec3* triangle = joined.triangles.begin();
  for (const Mesh& mesh : meshes) {
    if (mesh.positions.empty()) continue;
    joined.origin = mesh.origin;
    std::ranges::copy(mesh.positions, joined.positions.begin() + first_vertex);
    triangle =
        std::ranges::transform(mesh.triangles, triangle, [&](const glm::uvec3& t) { return t + first_vertex; }).out;
    first_vertex += static_cast<std::uint32_t>(mesh.positions.size());
  }
  return joined;
}

}  // namespace isoextract::mesh

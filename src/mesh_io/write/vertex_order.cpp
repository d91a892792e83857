#include "mesh_io/write/vertex_order.hpp"

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include <meshoptimizer.h>

namespace isoextract::mesh_io {

Result<void> optimize_order(mesh::Mesh& mesh, const Context& context) {
  if (mesh.triangles.empty()) return {};
  // Memory for meshoptimizer's tables of vertices and triangles, the new triangles, and the new vertices beside the
  // old.
  constexpr std::uint64_t kTriangleBytes = 48;
  constexpr std::uint64_t kVertexBytes = 24;
  const std::size_t vertices = mesh.positions.size();
  const auto memory = TRY(context.reserve(
      mesh.triangles.size() * kTriangleBytes + vertices * (kVertexBytes + mesh::vertex_bytes(mesh)), "ordering it"));
  const std::size_t corners = 3 * mesh.triangles.size();
  Buffer<glm::uvec3> triangles(mesh.triangles.size());
  std::uint32_t* indices = &triangles.data()->x;
  meshopt_optimizeVertexCache(indices, &mesh.triangles.data()->x, corners, vertices);

  constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> new_of_old(vertices);
  auto used =
      static_cast<std::uint32_t>(meshopt_optimizeVertexFetchRemap(new_of_old.data(), indices, corners, vertices));
  std::vector<std::uint32_t> old_of_new(vertices);
  for (std::size_t v = 0; v < vertices; ++v) {
    if (new_of_old[v] == kUnused) new_of_old[v] = used++;  // unused vertices are kept, at the end
    old_of_new[new_of_old[v]] = static_cast<std::uint32_t>(v);
  }
  meshopt_remapIndexBuffer(indices, indices, corners, new_of_old.data());
  mesh::gather_vertices(mesh, old_of_new);
  mesh.triangles = std::move(triangles);
  return {};
}

}  // namespace isoextract::mesh_io

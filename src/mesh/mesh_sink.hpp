// Takes a mesh in parts while it is made, so that no one holds the whole mesh.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/ranks.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// The properties of a mesh that are known before its arrays.
struct MeshShape {
  glm::dvec3 origin{0.0};  // Mesh::origin
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool has_normals = false;
  bool may_be_open = false;  // the mesh may have boundary edges
};

[[nodiscard]] inline MeshShape shape_of(const Mesh& mesh) {
  return {.origin = mesh.origin,
          .vertices = mesh.positions.size(),
          .triangles = mesh.triangles.size(),
          .has_normals = !mesh.normals.empty()};
}

// Consecutive vertices and consecutive triangles of a mesh. The arrays are as in Mesh.
struct MeshPart {
  std::uint64_t first_vertex = 0;
  std::span<const glm::vec3> positions;
  std::span<const glm::vec3> normals;  // one per position; or empty
  std::uint64_t first_triangle = 0;
  std::span<const glm::uvec3> triangles;  // indices of vertices of the whole mesh, also of those in other parts
};

class MeshSink {
 public:
  MeshSink() = default;
  MeshSink(const MeshSink&) = delete;
  MeshSink& operator=(const MeshSink&) = delete;
  virtual ~MeshSink() = default;

  // Returns the ranks that make the mesh together; null if this process makes all of it. All of them then call begin()
  // with the same shape, and each delivers some of the parts. If the sinks decline, rank 0 makes the mesh alone.
  [[nodiscard]] virtual Ranks* ranks() const { return nullptr; }
  // Prepares for a mesh of this shape. Called once, before the first part. Returns false if the caller should make the
  // mesh as a whole instead.
  [[nodiscard]] virtual Result<bool> begin(const MeshShape& shape) = 0;
  // Takes one part. Called from several threads at once, in any order; the parts of a mesh cover it without overlap.
  // The arrays are valid only during the call.
  [[nodiscard]] virtual Result<void> take(const MeshPart& part) = 0;
};

}  // namespace isoextract::mesh

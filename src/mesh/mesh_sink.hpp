// The interface of a receiver that takes a mesh part by part during extraction. The whole mesh is never in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/ranks.hpp"
#include "mesh/mesh.hpp"

namespace isoextract::mesh {

// The properties of a mesh that are known before its first part.
struct MeshShape {
  glm::dvec3 origin{0.0};  // Mesh::origin
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  bool has_normals = false;
  bool may_be_open = false;         // the mesh may have boundary edges
  bool distinct_positions = false;  // no two vertices have equal positions
  // If the parts come in order, triangles use no other vertices but those of their own part, of the next part, and
  // `far_vertices`. False: a triangle may use the vertices of any part.
  bool uses_near_vertices = true;
  // Vertices that triangles of later parts may use, ascending. If ranks make the mesh together: the consecutive first
  // vertices of this rank, which triangles of the rank before may use.
  std::vector<std::uint32_t> far_vertices = {};
  // Indices of the attributes that have a value that is not finite, ascending.
  std::vector<std::size_t> not_finite_attributes = {};
};

// Sets neither `may_be_open` and `not_finite_attributes`, which take a pass over the mesh, nor `distinct_positions` and
// `far_vertices`, which the extraction knows.
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
  std::span<const glm::uvec3> triangles;  // vertex indices in the whole mesh; the vertices may be in other parts
  std::span<const Attribute> attributes =
      {};  // all attributes of the mesh, with the values of these vertices; or empty
};

// One pass over the parts of a mesh. The mesh is made anew for each pass.
struct PartPass {
  // True: one part after another, in the order of the mesh. False: in any order, several threads call take() at once.
  bool in_order = false;
  // The arrays that the sink gets; the other arrays are empty. A part is left out if all its arrays are empty.
  bool positions = true;
  bool normals = true;
  bool triangles = true;
  bool attributes = false;  // an extraction makes none: its parts have only the arrays above
};

class MeshSink {
 public:
  MeshSink() = default;
  MeshSink(const MeshSink&) = delete;
  MeshSink& operator=(const MeshSink&) = delete;
  virtual ~MeshSink() = default;

  // Returns the ranks that make the mesh together; null if this process makes all of it. All of them then call begin()
  // with the same shape but for the far vertices, and each delivers some of the parts. If the sinks decline, rank 0
  // makes the mesh alone.
  [[nodiscard]] virtual Ranks* ranks() const { return nullptr; }
  // Prepares for vertices that come before begin(), while the extraction still counts. In `estimate`, the numbers of
  // vertices and triangles and may_be_open may be wrong, and far_vertices is empty. Returns false if the sink takes
  // no vertices yet. Otherwise take() may get parts without triangles until begin(), from several threads, and the
  // passes leave out these vertices. So a sink that needs vertices in several passes declines. If begin() is not called
  // or returns false, the sink forgets them. Never with ranks.
  [[nodiscard]] virtual Result<bool> begin_early(const MeshShape& /*estimate*/) { return false; }
  // Prepares for a mesh of this shape. Call once, before the first part but early ones. Returns false if the sink
  // declines the mesh: the caller then makes the whole mesh in memory.
  [[nodiscard]] virtual Result<bool> begin(const MeshShape& shape) = 0;
  // Returns the passes in which the sink takes the parts; the mesh is made once for each. Call after begin(), and again
  // after each end_pass(), which may have added passes.
  [[nodiscard]] virtual std::vector<PartPass> passes() const { return {PartPass()}; }
  // Called before the parts of each pass, with its index in passes().
  [[nodiscard]] virtual Result<void> begin_pass(std::size_t /*pass*/) { return {}; }
  // Takes one part, as passes() says. In each pass, the parts cover the mesh but for early vertices, without overlap.
  // The arrays of the part are valid only during the call.
  [[nodiscard]] virtual Result<void> take(const MeshPart& part) = 0;
  // Called after the parts of each pass.
  [[nodiscard]] virtual Result<void> end_pass() { return {}; }
  // Returns whether the sink declined the mesh only after a pass; then there are no more passes, and the caller makes
  // the whole mesh in memory. Never with ranks.
  [[nodiscard]] virtual bool has_declined() const { return false; }
  // Returns the mesh that the sink collected from the parts, which the caller then uses in place of the whole mesh;
  // nothing if the sink passed the parts on. Call it once, after the last pass. Never with ranks.
  [[nodiscard]] virtual std::optional<Mesh> take_collected() { return std::nullopt; }
};

}  // namespace isoextract::mesh

// The components of a mesh that comes in parts: a first pass links the components of the parts, and each later pass
// shows the parts with the component of every vertex. At a time, two parts are in memory, the vertices to which a cap
// refers, and some bytes for each component of each part.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/ranks.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::mesh {

// A part with all vertices that its triangles use. Local numbers count first the vertices of the part, then those of
// the next part that the triangles use, then, if the part is a cap, all far vertices (MeshShape::far_vertices).
struct LocalPart {
  std::uint64_t first_vertex = 0;               // of the part, in the whole mesh
  std::uint64_t first_triangle = 0;             // in the whole mesh, too
  std::size_t near = 0;                         // local numbers below this are vertices of the part or of the next one
  std::span<const glm::uvec3> triangles{};      // local numbers
  std::span<const glm::uvec3> numbered{};       // the same triangles, with vertex numbers of the whole mesh
  std::span<const glm::vec3> positions{};       // by local number
  std::span<const std::uint32_t> components{};  // by local number; Components::kNone: no triangle of the part uses it
  std::span<const glm::vec3> own_positions{};   // of all vertices of the part, in order
  std::span<const std::uint32_t> own_components{};  // of the vertices of the part, with the triangles of all parts
  std::span<const std::uint32_t> far{};             // MeshShape::far_vertices

  // Returns the number of a vertex in the whole mesh.
  [[nodiscard]] std::uint64_t number(std::uint32_t local) const {
    return local < near ? first_vertex + local : far[local - near];
  }
};

// Returns the error of a mesh that differs from that of an earlier pass. `name` is its name.
[[nodiscard]] tl::unexpected<Error> changed_between_passes(const std::string& name);

class PartwiseComponents {
 public:
  // Gets a part. The spans are valid only during the call.
  using Visit = std::function<Result<void>(const LocalPart& part)>;

  // `name` is the name of the mesh, for messages. `what` starts messages about memory.
  PartwiseComponents(std::string name, std::string what, const Context& context);
  ~PartwiseComponents();

  // All functions may fail with ErrorCode::out_of_memory, and throw std::bad_alloc.
  // If `ranks` share the mesh, each takes its parts, and all call begin(), number() and finish(), which then also fail
  // as Ranks::gather() does. `ranks` may be null.
  [[nodiscard]] Result<void> begin(const MeshShape& shape, Ranks* ranks);
  // Takes the parts of the first pass in order, with triangles.
  [[nodiscard]] Result<void> link(const MeshPart& part);
  // Ends the first pass: numbers the components in the order of their first vertices.
  [[nodiscard]] Result<void> number();

  [[nodiscard]] std::uint32_t count() const;
  // Returns the component of the far vertex with this index; Components::kNone if it has no triangle.
  [[nodiscard]] std::uint32_t of_far(std::size_t index) const;

  // Takes the parts of a later pass in order, with positions and triangles. Calls visit() for the part before this one,
  // whose triangles may use vertices of this one. finish() does so for the last part, and ends the pass. Both fail as
  // visit() does, and with ErrorCode::input if the mesh of this pass differs from that of the first one.
  [[nodiscard]] Result<void> take(const MeshPart& part, const Visit& visit);
  [[nodiscard]] Result<void> finish(const Visit& visit);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::mesh

// Selects bodies of a mesh that comes in parts, as select_bodies() does for a mesh in memory. Its passes link, measure
// and nest the components, and mark the vertices that stay. Then keep() gives the parts of the remaining mesh. In
// memory are two parts, 1.1 bits for each vertex, and some bytes for each component.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"
#include "edit/bodies.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::edit {

// Returns about how much memory select_bodies() takes for such a mesh, with the mesh. It is faster than PartwiseBodies.
[[nodiscard]] inline std::uint64_t whole_selection_bytes(std::uint64_t vertices, std::uint64_t triangles,
                                                         bool has_normals) {
  return (vertices * (has_normals ? 2 : 1) * sizeof(glm::vec3) + triangles * sizeof(glm::uvec3)) * 5 / 2;
}

class PartwiseBodies {
 public:
  using TakePart = std::function<Result<void>(const mesh::MeshPart& part)>;

  // `name` is the name of the mesh, for messages.
  PartwiseBodies(const std::string& name, const BodySelection& options, const Context& context);
  ~PartwiseBodies();

  // Prepares the selection. This and the next functions are used like those of mesh::MeshSink. They fail as
  // select_bodies() does, and with ErrorCode::input if a pass brings another mesh than the first one. end_pass() may
  // add passes.
  [[nodiscard]] Result<void> begin(const mesh::MeshShape& shape);
  [[nodiscard]] const std::vector<mesh::PartPass>& passes() const;
  [[nodiscard]] Result<void> begin_pass(std::size_t pass);
  [[nodiscard]] Result<void> take(const mesh::MeshPart& part);
  [[nodiscard]] Result<void> end_pass();

  // Call the rest after the last of these passes.
  [[nodiscard]] const BodyFigures& figures() const;
  [[nodiscard]] const mesh::MeshShape& kept_shape() const;
  // Calls take() with the rest of a part, unless nothing is left of it. Several threads may call it at once. Fails as
  // take() does, and as begin().
  [[nodiscard]] Result<void> keep(const mesh::MeshPart& part, const TakePart& take) const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::edit

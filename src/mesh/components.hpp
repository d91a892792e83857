// Connected components of a surface, found from indices alone.
#pragma once

#include <cstdint>
#include <limits>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::mesh {

// Two vertices belong to the same component if triangles connect them. Triangles that repeat an index do not connect
// vertices. The result is the same for any number of threads.
class Components {
 public:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  // All indices must be below `vertices`. The caller reserves bytes(). Throws std::bad_alloc.
  Components(std::span<const glm::uvec3> triangles, std::size_t vertices);

  [[nodiscard]] std::uint32_t count() const { return count_; }
  // Returns the component of a vertex, numbered from 0 in the order of their first vertices; kNone for a vertex that no
  // connecting triangle uses. A triangle belongs to the component of its vertices.
  [[nodiscard]] std::uint32_t of_vertex(std::size_t vertex) const { return label_[vertex]; }

  // Returns the component of each vertex.
  [[nodiscard]] std::span<const std::uint32_t> of_vertices() const { return label_.span(); }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices) { return vertices * sizeof(std::uint32_t); }

 private:
  Buffer<std::uint32_t> label_;
  std::uint32_t count_ = 0;
};

}  // namespace isoextract::mesh

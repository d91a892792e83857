// Finds vertices with equal coordinates.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::mesh {

// Maps each vertex to the first vertex with its coordinates; -0 equals 0. Does not depend on the number of threads.
class CoincidentVertices {
 public:
  // Needs finite positions. Uses bytes() of memory, which the caller reserves; throws std::bad_alloc.
  explicit CoincidentVertices(std::span<const glm::vec3> positions);

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices);

  [[nodiscard]] std::uint32_t of_vertex(std::uint32_t vertex) const { return first_[vertex]; }
  [[nodiscard]] glm::uvec3 of_triangle(const glm::uvec3& t) const { return {first_[t.x], first_[t.y], first_[t.z]}; }
  // Returns the number of vertices at the place of an earlier one.
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }

 private:
  Buffer<std::uint32_t> first_;
  std::uint64_t repeated_ = 0;
};

}  // namespace isoextract::mesh

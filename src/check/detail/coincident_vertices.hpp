// Finds vertices with equal coordinates and triangles with equal corners.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::check {

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

// The triangles with area, one for each set of three corners, in either winding.
struct UniqueTriangles {
  Buffer<std::uint32_t> triangles;  // the first triangle of each set, ascending
  Buffer<std::uint32_t> copies;     // size of each set
  std::uint64_t zero_area = 0;      // triangles whose corners are exactly on one line
  std::uint64_t duplicates = 0;     // triangles with area and the corners of an earlier one
};

// Uses distinct_triangle_bytes() of memory, which the caller reserves; throws std::bad_alloc.
[[nodiscard]] UniqueTriangles find_unique_triangles(std::span<const glm::vec3> positions,
                                                    std::span<const glm::uvec3> triangles,
                                                    const CoincidentVertices& places);
[[nodiscard]] std::uint64_t distinct_triangle_bytes(std::uint64_t triangles);

}  // namespace isoextract::check

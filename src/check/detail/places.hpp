// What lies at one place: vertices with the same coordinates, and triangles with the same corners.
#pragma once

#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"

namespace isoextract::check {

// Of each vertex the first one that has its coordinates; -0 is 0. The same for any number of threads.
class VertexPlaces {
 public:
  // Finite positions. Takes bytes(), which is the caller's to reserve; throws std::bad_alloc.
  explicit VertexPlaces(std::span<const glm::vec3> positions);

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t vertices);

  [[nodiscard]] std::uint32_t of_vertex(std::uint32_t vertex) const { return first_[vertex]; }
  [[nodiscard]] glm::uvec3 of_triangle(const glm::uvec3& t) const { return {first_[t.x], first_[t.y], first_[t.z]}; }
  // Vertices that lie where an earlier one does.
  [[nodiscard]] std::uint64_t repeated() const { return repeated_; }

 private:
  Buffer<std::uint32_t> first_;
  std::uint64_t repeated_ = 0;
};

// The triangles that have area, those of the same three corners once, whichever way they wind.
struct DistinctTriangles {
  Buffer<std::uint32_t> triangles;  // the first of each, in rising order
  Buffer<std::uint32_t> copies;     // of each, with itself
  std::uint64_t zero_area = 0;      // exactly: their corners are on one line
  std::uint64_t duplicates = 0;     // that have area and the corners of an earlier one
};

// Takes bytes of distinct_triangle_bytes(), which are the caller's to reserve; throws std::bad_alloc.
[[nodiscard]] DistinctTriangles find_distinct_triangles(std::span<const glm::vec3> positions,
                                                        std::span<const glm::uvec3> triangles,
                                                        const VertexPlaces& places);
[[nodiscard]] std::uint64_t distinct_triangle_bytes(std::uint64_t triangles);

}  // namespace isoextract::check

// Triangles at each vertex, found from indices alone: the corners at all vertices in compressed rows, and the edges and
// fans of one vertex.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/buckets.hpp"

namespace isoextract::mesh {

// A corner of a triangle: 3 * triangle + 0, 1 or 2.
using Corner = std::uint64_t;

[[nodiscard]] inline std::uint64_t triangle_of(Corner corner) { return corner / 3; }

[[nodiscard]] inline bool has_repeated_index(const glm::uvec3& t) { return t.x == t.y || t.y == t.z || t.z == t.x; }

// The corners at each vertex. The same for any number of threads.
class Adjacency {
 public:
  // All indices must be below `vertices`. The caller reserves bytes(). Throws std::bad_alloc.
  Adjacency(std::span<const glm::uvec3> triangles, std::size_t vertices);

  // Returns the corners in ascending order. A triangle that repeats an index has several corners at one vertex.
  [[nodiscard]] std::span<const Corner> corners(std::size_t vertex) const { return corners_.at(vertex); }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles, std::uint64_t vertices) {
    return Buckets<Corner>::bytes(3 * triangles, vertices);
  }

 private:
  Buckets<Corner> corners_;
};

// The edges at one vertex with their triangles, and the fans that these triangles form: edges at the vertex connect the
// triangles of a fan. Reuses its memory for the next vertex. Takes O(n log n) time for n corners.
class VertexStar {
 public:
  // A triangle along one edge of the vertex.
  struct Side {
    std::uint32_t end;     // the other vertex of the edge
    std::uint32_t corner;  // index of the triangle's corner in the argument of look_at()
    bool outgoing;         // whether the triangle runs along the edge away from the vertex
  };

  // Examines one vertex of `triangles`. `corners` are all its corners, or a subset to consider. Throws std::bad_alloc.
  void look_at(std::span<const Corner> corners, std::span<const glm::uvec3> triangles);

  // Returns two sides per corner, sorted by `end`, then by `corner`, so that the sides of one edge are adjacent.
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }

  [[nodiscard]] std::uint32_t fans() const { return fans_; }
  // Returns the fan of each corner passed to look_at(), numbered from 0 in the order of their first corners.
  [[nodiscard]] std::span<const std::uint32_t> fan_of() const { return fan_of_; }

  // Returns whether the triangles form one closed fan: two at each edge, which run along it in opposite directions, and
  // none that contains the vertex twice.
  [[nodiscard]] bool is_closed_fan() const;

 private:
  void number_fans();

  std::uint32_t vertex_ = 0;
  std::uint32_t fans_ = 0;
  std::vector<Side> sides_;
  std::vector<std::uint32_t> fan_of_;
};

}  // namespace isoextract::mesh

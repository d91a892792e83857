// Which triangles meet at a vertex and in its edges, found from indices alone: compressed rows of corners, and the
// edges and fans of one vertex made of its row.
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

[[nodiscard]] inline bool repeats_index(const glm::uvec3& t) { return t.x == t.y || t.y == t.z || t.z == t.x; }

// The corners at each vertex. The same for any number of threads.
class Adjacency {
 public:
  // Indices below `vertices`. Takes bytes(), which is the caller's to reserve; throws std::bad_alloc.
  Adjacency(std::span<const glm::uvec3> triangles, std::size_t vertices);

  // In rising order, and so are their triangles. A triangle that repeats an index has several corners at its vertex.
  [[nodiscard]] std::span<const Corner> corners(std::size_t vertex) const { return corners_.at(vertex); }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles, std::uint64_t vertices) {
    return Buckets<Corner>::bytes(3 * triangles, vertices);
  }

 private:
  Buckets<Corner> corners_;
};

// The edges at one vertex, each with its triangles, and the fans that the triangles form: those of one fan are joined
// by edges at the vertex. Looks at one vertex after the other and keeps its memory; takes n log n time for n corners.
class VertexStar {
 public:
  // Where a triangle runs along an edge at the vertex.
  struct Side {
    std::uint32_t end;     // the vertex at the edge's other end
    std::uint32_t corner;  // the triangle's, as its place in what was looked at
    bool outgoing;         // from the vertex to the end
  };

  // `corners` are of one vertex of `triangles`, all of them or those that count. Throws std::bad_alloc.
  void look_at(std::span<const Corner> corners, std::span<const glm::uvec3> triangles);

  // Two a corner: edge by edge, their ends rising; those of one edge by their corners.
  [[nodiscard]] std::span<const Side> sides() const { return sides_; }

  [[nodiscard]] std::uint32_t fans() const { return fans_; }
  // Of each corner, in the order of the fans' first corners.
  [[nodiscard]] std::span<const std::uint32_t> fan_of() const { return fan_of_; }

  // Whether the triangles go round the vertex once, two at each edge that run along it in opposite directions, and none
  // of them has the vertex twice.
  [[nodiscard]] bool is_closed_fan() const;

 private:
  void number_fans();

  std::uint32_t vertex_ = 0;
  std::uint32_t fans_ = 0;
  std::vector<Side> sides_;
  std::vector<std::uint32_t> fan_of_;
};

}  // namespace isoextract::mesh

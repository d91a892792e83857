// The one-sided Hausdorff distance: that of the point of a mesh's triangles that is farthest from a surface, anywhere
// on them, as an interval that holds it.
//
// Vertices say how far it is at least. Triangles that may be farther are then looked at (distance_bound.hpp), the
// widest bounds first, in rounds: what a round finds spares the next ones work. Everything is computed in double, and
// is the same for any number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "mesh/distance_bound.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::mesh {

// Triangles in the frame of a tree, into which `shift` takes them. The memory is the caller's.
struct PlacedTriangles {
  std::span<const glm::vec3> positions;
  std::span<const glm::uvec3> triangles;
  std::span<const char> left_out;  // of each triangle, whether it has no say; empty: all have
  glm::dvec3 shift{0.0};
};

struct GreatestDistance {
  double lower = 0;  // the distance of `place`
  double upper = 0;  // no point is farther
  glm::dvec3 place{0.0};
  glm::dvec3 nearest{0.0};
};

// In three steps, between which a caller may tell distances that it knows of. Where the context is cancelled they end
// early, and what they found means nothing.
class GreatestDistanceSearch {
 public:
  // What the references and spans lead to must outlive it.
  GreatestDistanceSearch(const PlacedTriangles& from, const TriangleTree& to, const DistanceLimits& limits,
                         const Context& context);

  // What it takes at most.
  [[nodiscard]] static constexpr std::uint64_t bytes(std::uint64_t vertices, std::uint64_t triangles) {
    return vertices * (sizeof(Corner) + 1) + triangles * (sizeof(double) + sizeof(Open) + sizeof(TriangleBound));
  }

  // Vertices of triangles that are left out have no say, unless others use them. If none has, the distance is 0.
  void measure_corners();
  // A point of the triangles, in the frame of the tree.
  void take_nearest_of(const glm::dvec3& p, std::uint32_t hint);
  // Last.
  GreatestDistance bound_triangles();

  [[nodiscard]] double lower() const { return found_.lower; }

 private:
  struct Corner {
    double distance_squared = 0;
    std::uint32_t slot = 0;
  };
  struct Open {
    double upper;
    std::uint32_t triangle;
  };

  [[nodiscard]] glm::dvec3 point(std::uint32_t vertex) const {
    return glm::dvec3(from_.positions[vertex]) + from_.shift;
  }
  [[nodiscard]] bool counts(std::size_t triangle) const {
    return from_.left_out.empty() || from_.left_out[triangle] == 0;
  }
  void take(double distance, const glm::dvec3& place, const glm::dvec3& nearest);
  [[nodiscard]] double distance_squared(std::uint32_t vertex, std::uint32_t slot) const;
  [[nodiscard]] double quick_upper(const glm::uvec3& t) const;

  PlacedTriangles from_;
  const TriangleTree& to_;
  DistanceLimits limits_;
  const Context& context_;
  std::vector<Corner> corners_;  // of each vertex
  bool has_place_ = false;
  GreatestDistance found_;
};

}  // namespace isoextract::mesh

// The one-sided Hausdorff distance of a mesh from a surface: an interval for the greatest distance of any point of its
// triangles.
//
// Distances at vertices give a lower bound. Then triangles that may be farther are bounded (distance_bound.hpp), those
// with the greatest upper bounds first, in rounds: the result of a round saves work in the next ones. All computations
// are in double and give the same result for any number of threads.
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

// Triangles whose positions plus `shift` are in the frame of a tree. Does not own its data.
struct PlacedTriangles {
  std::span<const glm::vec3> positions;
  std::span<const glm::uvec3> triangles;
  std::span<const char> left_out;  // nonzero for each triangle to ignore; empty: none
  glm::dvec3 shift{0.0};
};

struct GreatestDistance {
  double lower = 0;         // the distance of `place`
  double upper = 0;         // an upper bound for all points
  glm::dvec3 place{0.0};    // in the frame of the tree, like `nearest`
  glm::dvec3 nearest{0.0};  // the point of the surface nearest to `place`
};

// A search in three steps; between them a caller may add distances that it knows. If the context is cancelled, the
// steps end early and their results are meaningless.
class GreatestDistanceSearch {
 public:
  // `from` needs at least one triangle. All references and spans must outlive the search.
  GreatestDistanceSearch(const PlacedTriangles& from, const TriangleTree& to, const DistanceLimits& limits,
                         const Context& context);

  // Returns the most bytes that the search needs.
  [[nodiscard]] static constexpr std::uint64_t bytes(std::uint64_t vertices, std::uint64_t triangles) {
    return vertices * (sizeof(Corner) + 1) + triangles * (sizeof(double) + sizeof(Open) + sizeof(TriangleBound));
  }

  // Step 1: measures the vertices of triangles that are not left out. If all triangles are left out, the distance is 0.
  void measure_corners();
  // Step 2, optional: adds a point of the triangles, in the frame of the tree. `hint` is a slot of the tree.
  void add_point(const glm::dvec3& p, std::uint32_t hint);
  // Step 3: bounds the triangles and returns the result.
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
  [[nodiscard]] double upper_bound_by_corners(const glm::uvec3& t) const;

  PlacedTriangles from_;
  const TriangleTree& to_;
  DistanceLimits limits_;
  const Context& context_;
  std::vector<Corner> corners_;  // one per vertex
  bool has_place_ = false;
  GreatestDistance found_;
};

}  // namespace isoextract::mesh

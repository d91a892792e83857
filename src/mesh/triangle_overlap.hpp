// Tests exactly whether two triangles have a common point besides the corner or the edge that they share.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::mesh {

struct PlacedTriangle {
  std::array<glm::dvec3, 3> corners;  // float32 coordinates, not on one line
};

struct TriangleOverlap {
  bool meet = false;
  bool in_one_plane = false;  // only set if they meet
  bool neighbors = false;     // they share a corner or a side; only set if they meet
};

// Triangles include their border, so touching is meeting. Corners with equal coordinates are shared. Triangles that
// share all three corners meet.
//
// Without a shared corner, two triangles meet if a side of one meets the other. With one shared corner, their
// intersection is convex and contains it; if it holds more, it reaches the opposite side of one triangle. With a shared
// side, they overlap if they lie in one plane on the same side of it.
[[nodiscard]] TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q);

// Rejects most pairs with a triangle by its plane, without a call of find_overlap().
//
// Computes the determinants of orientation_3d() in double, from the cofactors of the plane, and compares them with a
// bound of the rounding error (Shewchuk, see exact_sign.hpp) that is generous by a factor of 2.
class PlaneFilter {
 public:
  explicit PlaneFilter(const PlacedTriangle& p) : corners_(p.corners) {
    const glm::dvec3 a = corners_[1] - corners_[0];
    const glm::dvec3 b = corners_[2] - corners_[0];
    const glm::dvec3 first(a.y * b.z, a.z * b.x, a.x * b.y);
    const glm::dvec3 second(a.z * b.y, a.x * b.z, a.y * b.x);
    normal_ = first - second;
    constexpr double kRounding = 16.0 / (1ULL << 53U);
    rounding_ = kRounding * (glm::abs(first) + glm::abs(second));
  }

  // Returns true only if find_overlap() finds that the triangles do not meet: the corners of q that they do not share
  // are all on one side of the plane.
  [[nodiscard]] bool is_apart(const PlacedTriangle& q) const {
    int sides = 0;  // bit 0: a corner above, bit 1: below
    for (const glm::dvec3& corner : q.corners) {
      if (corner == corners_[0] || corner == corners_[1] || corner == corners_[2]) continue;
      const glm::dvec3 way = corner - corners_[0];
      const double height = glm::dot(normal_, way);
      const double rounding = glm::dot(rounding_, glm::abs(way));
      if (!(std::abs(height) > rounding)) return false;
      sides |= height > 0 ? 1 : 2;
    }
    return sides == 1 || sides == 2;
  }

 private:
  std::array<glm::dvec3, 3> corners_;
  glm::dvec3 normal_;
  glm::dvec3 rounding_;  // of each product with `normal_`, relative to the other factor
};

}  // namespace isoextract::mesh

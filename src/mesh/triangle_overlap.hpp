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
    std::array<int, 3> sides;  // 0: too near to tell
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 way = q.corners[i] - corners_[0];
      const double height = glm::dot(normal_, way);
      const double rounding = glm::dot(rounding_, glm::abs(way));
      sides[i] = (height > rounding ? 1 : 0) - (height < -rounding ? 1 : 0);
    }
    int side = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      if (sides[i] == 0 && !is_corner(q.corners[i])) return false;
      if (sides[i] * side < 0) return false;
      side += sides[i];
    }
    return side != 0;
  }

 private:
  [[nodiscard]] bool is_corner(const glm::dvec3& p) const {
    return p == corners_[0] || p == corners_[1] || p == corners_[2];
  }

  std::array<glm::dvec3, 3> corners_;
  glm::dvec3 normal_;
  glm::dvec3 rounding_;  // of each product with `normal_`, relative to the other factor
};

}  // namespace isoextract::mesh

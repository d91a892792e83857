// Tests exactly whether two triangles have a common point besides the corner or the edge that they share.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include <glm/glm.hpp>

#include "mesh/float4.hpp"

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
// intersection is convex and contains the corner; a larger intersection reaches the side opposite this corner in one
// triangle. With a shared side, they overlap if they lie in one plane and on one side of the shared side.
[[nodiscard]] TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q);

// The corners of a triangle, a lane for each; the last lane repeats the last corner.
struct CornerLanes {
  Float4 x, y, z;

  explicit CornerLanes(const std::array<glm::vec3, 3>& t)
      : x{t[0].x, t[1].x, t[2].x, t[2].x}, y{t[0].y, t[1].y, t[2].y, t[2].y}, z{t[0].z, t[1].z, t[2].z, t[2].z} {}
};

// Rejects most partners of one triangle by its plane, without a call of find_overlap().
//
// Computes the determinants of orientation_3d() in float and compares them with a bound of the rounding error: each
// term is a product of three differences (Shewchuk, see exact_sign.hpp, with a generous constant).
class PlaneFilter {
 public:
  explicit PlaneFilter(const std::array<glm::vec3, 3>& p) {
    const glm::dvec3 origin(p[0]);
    const glm::dvec3 a = glm::dvec3(p[1]) - origin;
    const glm::dvec3 b = glm::dvec3(p[2]) - origin;
    const glm::dvec3 first(a.y * b.z, a.z * b.x, a.x * b.y);
    const glm::dvec3 second(a.z * b.y, a.x * b.z, a.y * b.x);
    constexpr double kRounding = 16.0 / (1 << 24);
    const glm::vec3 normal = first - second;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<int>(i);
      normal_[i] = splat4(normal[axis]);
      // glm::abs() would branch on each sign.
      const double magnitude = std::abs(first[axis]) + std::abs(second[axis]);
      rounding_[i] = splat4(static_cast<float>(kRounding * magnitude));
      corners_[i] = {splat4(p[i].x), splat4(p[i].y), splat4(p[i].z)};
    }
  }

  // Returns true only if find_overlap() would find that the triangles do not meet: all corners of q except shared ones
  // are on one side of the plane.
  [[nodiscard]] bool is_apart(const CornerLanes& q) const {
    const Float4 x = q.x - corners_[0][0];
    const Float4 y = q.y - corners_[0][1];
    const Float4 z = q.z - corners_[0][2];
    const Float4 height = normal_[0] * x + normal_[1] * y + normal_[2] * z;
    // The least number covers products that underflow.
    const Float4 rounding = rounding_[0] * magnitude4(x) + rounding_[1] * magnitude4(y) + rounding_[2] * magnitude4(z) +
                            std::numeric_limits<float>::min();
    constexpr float kMost = std::numeric_limits<float>::max();
    const Mask4 is_above = (height > rounding) & (height <= kMost);  // a sum that overflows tells nothing
    const Mask4 is_below = (-height > rounding) & (-height <= kMost);
    if (any4(is_above) == any4(is_below)) return false;
    const Mask4 is_off = is_above | is_below;
    if (all4(is_off)) return true;
    Mask4 is_shared{};
    for (const auto& corner : corners_) is_shared |= (q.x == corner[0]) & (q.y == corner[1]) & (q.z == corner[2]);
    return all4(is_off | is_shared);
  }

 private:
  std::array<std::array<Float4, 3>, 3> corners_;  // each coordinate in all lanes, as below
  std::array<Float4, 3> normal_;
  std::array<Float4, 3> rounding_;  // of each product with `normal_`, relative to the other factor
};

}  // namespace isoextract::mesh

// Bounds the distance of a point to boxes from below, in float, four lanes at a time.
#pragma once

#include <algorithm>
#include <limits>

#include <glm/glm.hpp>

#include "mesh/box_tree.hpp"
#include "mesh/float4.hpp"

namespace isoextract::mesh {

class BoxFilter {
 public:
  explicit BoxFilter(const glm::dvec3& p) {
    const Float4 at{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0};
    const Float4 rounding = magnitude4(at) * kRounding + std::numeric_limits<float>::min();
    low_ = at - rounding;
    high_ = at + rounding;
    low_[3] = -std::numeric_limits<float>::infinity();
    high_[3] = std::numeric_limits<float>::infinity();
  }

  // Returns a lower bound of the squared distance of the point to the box.
  [[nodiscard]] double bound(const FloatBox& box) const {
    static_assert(sizeof(FloatBox) == 6 * sizeof(float));
    return bound(load4(&box.min.x), last_three(load4(&box.min.z)));
  }
  // Returns the bound for the bounding box of a triangle, whose corners follow each other in memory.
  [[nodiscard]] double bound_of_triangle(const glm::vec3* corners) const {
    const Float4 a = load4(&corners[0].x);
    const Float4 b = load4(&corners[1].x);
    const Float4 c = last_three(load4(&corners[1].z));
    return bound(min4(min4(a, b), c), max4(max4(a, b), c));
  }

 private:
  static constexpr float kRounding = 3e-7F;  // more than a float rounds, relative to the number

  // Returns a lower bound of the squared distance. A lane that a number beyond float makes NaN counts as 0.
  [[nodiscard]] double bound(const Float4& low, const Float4& high) const {
    const Float4 away = max4(max4(low - high_, low_ - high), Float4{});
    const Float4 squared = away * away;
    const float sum = squared[0] + squared[1] + squared[2];
    constexpr double kLess = 1 - 1e-6;  // more than rounding of the sum; kLeast covers underflow
    constexpr double kLeast = std::numeric_limits<float>::min();
    // An infinite sum means that the square of the distance is above the largest float.
    return std::min(static_cast<double>(sum), double{std::numeric_limits<float>::max()}) * kLess - kLeast;
  }

  // x, y, z and a lane that does not count.
  Float4 low_;  // the point, rounded down and up
  Float4 high_;
};

}  // namespace isoextract::mesh

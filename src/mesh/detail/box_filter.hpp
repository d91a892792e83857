// Rejects boxes and triangles that are too far from a point, in float, four lanes at a time.
#pragma once

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

  // Returns the limit for a squared distance in double: no smaller, by more than the rounding of the tests below.
  [[nodiscard]] static float limit(double squared) {
    constexpr double kMore = 1 + 1e-6;
    return static_cast<float>(squared * kMore) + std::numeric_limits<float>::min();
  }

  // The functions return true only if the squared distance of the point to the box is above the one that the limit was
  // made from.
  [[nodiscard]] bool is_beyond(const FloatBox& box, float limit) const {
    static_assert(sizeof(FloatBox) == 6 * sizeof(float));
    return is_beyond(load4(&box.min.x), last_three(load4(&box.min.z)), limit);
  }
  // The box is that of a triangle, whose corners follow each other in memory.
  [[nodiscard]] bool is_triangle_beyond(const glm::vec3* corners, float limit) const {
    const Float4 a = load4(&corners[0].x);
    const Float4 b = load4(&corners[1].x);
    const Float4 c = last_three(load4(&corners[1].z));
    return is_beyond(min4(min4(a, b), c), max4(max4(a, b), c), limit);
  }

 private:
  static constexpr float kRounding = 3e-7F;  // more than a float rounds, relative to the number

  // A number that is not finite in float makes a lane NaN, which counts as 0.
  [[nodiscard]] bool is_beyond(const Float4& low, const Float4& high, float limit) const {
    const Float4 away = max4(max4(low - high_, low_ - high), Float4{});
    const Float4 squared = away * away;
    return squared[0] + squared[1] + squared[2] > limit;
  }

  // x, y, z and a lane that does not count.
  Float4 low_;  // the point, rounded down and up
  Float4 high_;
};

}  // namespace isoextract::mesh

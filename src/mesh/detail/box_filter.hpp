// Rejects boxes and triangles that are too far from a point, in float, four lanes at a time.
#pragma once

#include <cstring>
#include <limits>

#include <glm/glm.hpp>

#include "mesh/box_tree.hpp"

namespace isoextract::mesh {

class BoxFilter {
 public:
  explicit BoxFilter(const glm::dvec3& p) {
    const Lanes at{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), 0};
    const Lanes size = at < 0 ? -at : at;
    const Lanes rounding = size * kRounding + std::numeric_limits<float>::min();
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
    return is_beyond(load(&box.min.x), last_three(load(&box.min.z)), limit);
  }
  // The box is that of a triangle, whose corners follow each other in memory.
  [[nodiscard]] bool is_triangle_beyond(const glm::vec3* corners, float limit) const {
    const Lanes a = load(&corners[0].x);
    const Lanes b = load(&corners[1].x);
    const Lanes c = last_three(load(&corners[1].z));
    return is_beyond(least(least(a, b), c), greatest(greatest(a, b), c), limit);
  }

 private:
  using Lanes = float __attribute__((vector_size(16)));  // x, y, z and one that does not count
  static constexpr float kRounding = 3e-7F;              // more than a float rounds, relative to the number

  [[nodiscard]] static Lanes load(const float* from) {
    Lanes lanes;
    std::memcpy(&lanes, from, sizeof(lanes));
    return lanes;
  }
  [[nodiscard]] static Lanes last_three(const Lanes& v) { return Lanes{v[1], v[2], v[3], v[0]}; }
  [[nodiscard]] static Lanes least(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
  [[nodiscard]] static Lanes greatest(const Lanes& a, const Lanes& b) { return a > b ? a : b; }

  // A number that is not finite in float makes a lane NaN, which counts as 0.
  [[nodiscard]] bool is_beyond(const Lanes& low, const Lanes& high, float limit) const {
    const Lanes away = greatest(greatest(low - high_, low_ - high), Lanes{});
    const Lanes squared = away * away;
    return squared[0] + squared[1] + squared[2] > limit;
  }

  Lanes low_;  // the point, rounded down and up
  Lanes high_;
};

}  // namespace isoextract::mesh

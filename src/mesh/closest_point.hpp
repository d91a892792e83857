// The closest point on a triangle.
#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace isoextract::mesh {

// Returns the point closest to `p` on the segment from a to b, which may have length 0.
[[nodiscard]] inline glm::dvec3 closest_on_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double length_squared = glm::dot(ab, ab);
  if (!(length_squared > 0)) return a;
  return a + std::clamp(glm::dot(p - a, ab) / length_squared, 0.0, 1.0) * ab;
}

// A triangle a, b, c, possibly of area 0, to measure the distances of points to.
//
// Computes in double the foot of the perpendicular if it lies in the triangle, else the closest point on the sides. It
// finds the region of the triangle's plane that the point is over (C. Ericson, Real-Time Collision Detection, 2005,
// 5.1.5). In needles, rounding moves the foot along the needle, so the class takes the foot only if it is closer than
// the sides. If the angle at a is within 1e-8 radians of 0 or 180 degrees, the plane is lost, and only the sides count.
class ClosestPointTriangle {
 public:
  ClosestPointTriangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
      : a_(a),
        b_(b),
        c_(c),
        ab_(b - a),
        ac_(c - a),
        b_squared_(glm::dot(ab_, ab_)),
        c_squared_(glm::dot(ac_, ac_)),
        between_(glm::dot(ab_, ac_)),
        needle_(is_needle()) {}

  [[nodiscard]] glm::dvec3 closest(const glm::dvec3& p) const {
    return needle_ ? closest_on_needle(p) : closest_by_region(p);
  }

  [[nodiscard]] double distance_squared(const glm::dvec3& p) const {
    const glm::dvec3 way = p - closest(p);
    return glm::dot(way, way);
  }

 private:
  // Returns the squared length that cross(ab, ac) would have with a right angle at a.
  [[nodiscard]] double right_angle_area_squared() const { return b_squared_ * c_squared_; }

  [[nodiscard]] bool is_needle() const {
    constexpr double kNeedle = 1e-4;  // the square of an angle
    const double gram = right_angle_area_squared() - between_ * between_;
    return !(gram > kNeedle * std::max({right_angle_area_squared(), b_squared_ * b_squared_, c_squared_ * c_squared_}));
  }

  [[nodiscard]] glm::dvec3 closest_by_region(const glm::dvec3& p) const {
    const glm::dvec3 ap = p - a_;
    const double b_of_a = glm::dot(ab_, ap);
    const double c_of_a = glm::dot(ac_, ap);
    if (b_of_a <= 0 && c_of_a <= 0) return a_;
    const double b_of_b = b_of_a - b_squared_;
    const double c_of_b = c_of_a - between_;
    if (b_of_b >= 0 && c_of_b <= b_of_b) return b_;
    const double at_c = b_of_a * c_of_b - b_of_b * c_of_a;
    if (at_c <= 0 && b_of_a >= 0 && b_of_b <= 0) return a_ + b_of_a / b_squared_ * ab_;
    const double b_of_c = b_of_a - between_;
    const double c_of_c = c_of_a - c_squared_;
    if (c_of_c >= 0 && b_of_c <= c_of_c) return c_;
    const double at_b = b_of_c * c_of_a - b_of_a * c_of_c;
    if (at_b <= 0 && c_of_a >= 0 && c_of_c <= 0) return a_ + c_of_a / c_squared_ * ac_;
    const double at_a = b_of_b * c_of_c - b_of_c * c_of_b;
    const double to_c = c_of_b - b_of_b;
    const double to_b = b_of_c - c_of_c;
    if (at_a <= 0 && to_c >= 0 && to_b >= 0) return b_ + to_c / (to_c + to_b) * (c_ - b_);
    const double sum = at_a + at_b + at_c;
    return a_ + at_b / sum * ab_ + at_c / sum * ac_;
  }

  [[nodiscard]] glm::dvec3 closest_on_needle(const glm::dvec3& p) const {
    const glm::dvec3 normal = glm::cross(ab_, ac_);
    const double area_squared = glm::dot(normal, normal);
    glm::dvec3 nearest = closest_on_segment(p, a_, b_);
    double least = glm::dot(p - nearest, p - nearest);
    const auto consider = [&](const glm::dvec3& q) {
      const double distance = glm::dot(p - q, p - q);
      if (distance >= least) return;
      least = distance;
      nearest = q;
    };
    consider(closest_on_segment(p, b_, c_));
    consider(closest_on_segment(p, c_, a_));
    if (area_squared > 1e-16 * right_angle_area_squared()) {
      const glm::dvec3 ap = p - a_;
      const double at_b = glm::dot(glm::cross(ap, ac_), normal);
      const double at_c = glm::dot(glm::cross(ab_, ap), normal);
      if (at_b >= 0 && at_c >= 0 && at_b + at_c <= area_squared) {
        consider(a_ + at_b / area_squared * ab_ + at_c / area_squared * ac_);
      }
    }
    return nearest;
  }

  glm::dvec3 a_, b_, c_;
  glm::dvec3 ab_, ac_;
  double b_squared_, c_squared_, between_;
  bool needle_;
};

}  // namespace isoextract::mesh

// The closest point of a triangle.
#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace isoextract::mesh {

// The point of the segment from a to b, which may be without length, that is closest to `p`.
[[nodiscard]] inline glm::dvec3 closest_on_segment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 ab = b - a;
  const double length_squared = glm::dot(ab, ab);
  if (!(length_squared > 0)) return a;
  return a + std::clamp(glm::dot(p - a, ab) / length_squared, 0.0, 1.0) * ab;
}

// The point of the triangle a, b, c, which may be without area, that is closest to `p`. In double: the foot of the
// perpendicular if that lies in the triangle, or the nearest point of the sides. By the region of the triangle's plane
// that p is over (C. Ericson, Real-Time Collision Detection, 2005, 5.1.5), unless the triangle is a needle: these have
// their foot moved along them by rounding, therefore always the nearer of both; below 1e-8 radians the plane is lost,
// and the sides are all there is.
[[nodiscard]] inline glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                                    const glm::dvec3& c) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const double b_squared = glm::dot(ab, ab);
  const double c_squared = glm::dot(ac, ac);
  const double between = glm::dot(ab, ac);
  const double full_squared = b_squared * c_squared;  // of a right angle at a
  constexpr double kNeedle = 1e-4;                    // the square of an angle
  const double gram = full_squared - between * between;
  if (gram > kNeedle * std::max({full_squared, b_squared * b_squared, c_squared * c_squared})) {
    const glm::dvec3 ap = p - a;
    const double b_of_a = glm::dot(ab, ap);
    const double c_of_a = glm::dot(ac, ap);
    if (b_of_a <= 0 && c_of_a <= 0) return a;
    const double b_of_b = b_of_a - b_squared;
    const double c_of_b = c_of_a - between;
    if (b_of_b >= 0 && c_of_b <= b_of_b) return b;
    const double at_c = b_of_a * c_of_b - b_of_b * c_of_a;
    if (at_c <= 0 && b_of_a >= 0 && b_of_b <= 0) return a + b_of_a / b_squared * ab;
    const double b_of_c = b_of_a - between;
    const double c_of_c = c_of_a - c_squared;
    if (c_of_c >= 0 && b_of_c <= c_of_c) return c;
    const double at_b = b_of_c * c_of_a - b_of_a * c_of_c;
    if (at_b <= 0 && c_of_a >= 0 && c_of_c <= 0) return a + c_of_a / c_squared * ac;
    const double at_a = b_of_b * c_of_c - b_of_c * c_of_b;
    const double to_c = c_of_b - b_of_b;
    const double to_b = b_of_c - c_of_c;
    if (at_a <= 0 && to_c >= 0 && to_b >= 0) return b + to_c / (to_c + to_b) * (c - b);
    const double sum = at_a + at_b + at_c;
    return a + at_b / sum * ab + at_c / sum * ac;
  }
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double area_squared = glm::dot(normal, normal);
  glm::dvec3 nearest = closest_on_segment(p, a, b);
  double least = glm::dot(p - nearest, p - nearest);
  const auto consider = [&](const glm::dvec3& q) {
    const double distance = glm::dot(p - q, p - q);
    if (distance >= least) return;
    least = distance;
    nearest = q;
  };
  consider(closest_on_segment(p, b, c));
  consider(closest_on_segment(p, c, a));
  if (area_squared > 1e-16 * full_squared) {
    const glm::dvec3 ap = p - a;
    const double at_b = glm::dot(glm::cross(ap, ac), normal);
    const double at_c = glm::dot(glm::cross(ab, ap), normal);
    if (at_b >= 0 && at_c >= 0 && at_b + at_c <= area_squared) {
      consider(a + at_b / area_squared * ab + at_c / area_squared * ac);
    }
  }
  return nearest;
}

}  // namespace isoextract::mesh

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
// perpendicular if that lies in the triangle, or the nearest point of the sides. Needles have their foot moved along
// them by rounding, therefore always the nearer of both; below 1e-8 radians the plane is lost, and the sides are all
// there is.
[[nodiscard]] inline glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                                    const glm::dvec3& c) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 normal = glm::cross(ab, ac);
  const double area_squared = glm::dot(normal, normal);
  const double full_squared = glm::dot(ab, ab) * glm::dot(ac, ac);  // of a right angle at a
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

// On which side a point lies of a line or a plane, without rounding: the signs of determinants of float32 coordinates.
//
// J. R. Shewchuk: Adaptive precision floating-point arithmetic and fast robust geometric predicates. Discrete &
// Computational Geometry 18, 1997. A determinant in double with a bound of its error decides almost always; the rest is
// summed exactly, as expansions of doubles. All that occurs is a multiple of 2^-447 and below 2^390, so that nothing
// underflows or overflows, and the signs are right for all finite coordinates.
#pragma once

#include <glm/glm.hpp>

namespace isoextract::mesh {

// Points have float32 coordinates, which double holds. The sign is -1, 0 or 1.

// Positive where a, b and c run counter-clockwise seen from the side on which d is; 0 where all four are in one plane.
[[nodiscard]] int side_of_plane(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d);

// On which side the line through p along `way`, whose coordinates are whole numbers below 2^20, passes the line from a
// to b: the sign of the determinant of way, a - p and b - p. Where they meet, p counts as moved by (e, e^2, e^3) for an
// infinitesimal e > 0, so that it is 0 only where a and b are on one line along `way`. Positive all around a triangle
// abc that the line passes through and whose normal is along `way`.
[[nodiscard]] int side_of_line(const glm::dvec3& way, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p);

// Positive where a, b and c run counter-clockwise; 0 where they are on one line.
[[nodiscard]] int turn_of(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c);

// Without the coordinate of `axis`; the other two in the order that keeps the sense of rotation seen from where the
// coordinate is greater.
[[nodiscard]] inline glm::dvec2 along_axis(const glm::dvec3& p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

// Whether the three are on one line.
[[nodiscard]] bool are_collinear(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace isoextract::mesh

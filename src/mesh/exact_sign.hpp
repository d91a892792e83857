// Exact predicates for the side of a point relative to a line or a plane: signs of determinants of float32 coordinates.
//
// J. R. Shewchuk: Adaptive precision floating-point arithmetic and fast robust geometric predicates. Discrete &
// Computational Geometry 18, 1997. A determinant in double with an error bound almost always gives the sign. The other
// determinants are summed exactly, as expansions of doubles. All terms are multiples of 2^-447 below 2^390, so that
// nothing underflows or overflows, and the signs are exact for all finite coordinates.
#pragma once

#include <glm/glm.hpp>

namespace isoextract::mesh {

// Points have float32 coordinates, stored in double. The functions return -1, 0 or 1.

// Returns 1 if a, b and c run counter-clockwise seen from d, 0 if all four points are coplanar.
[[nodiscard]] int orientation_3d(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d);

// Returns the side on which the line through p in direction `way` passes the line from a to b: the sign of the
// determinant of way, a - p and b - p. `way` has integer coordinates below 2^20. If the lines meet, p counts as moved
// by (e, e^2, e^3) for an infinitesimal e > 0. The result then is 0 only if a and b lie on a line along `way`.
//
// For a triangle abc that the line passes through, the results for the edges ab, bc and ca have one sign. It is
// positive if the dot product of the triangle's normal and `way` is above 0.
[[nodiscard]] int side_of_line(const glm::dvec3& way, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& p);

// Returns 1 if a, b and c run counter-clockwise, 0 if they are collinear.
[[nodiscard]] int orientation_2d(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c);

// Projects p along `axis`. The order of the other two coordinates keeps the sense of rotation seen from the positive
// end of the axis.
[[nodiscard]] inline glm::dvec2 along_axis(const glm::dvec3& p, int axis) {
  return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
}

// Returns the exact answer, as orientation_2d() does; coinciding points are collinear.
[[nodiscard]] bool are_collinear(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace isoextract::mesh

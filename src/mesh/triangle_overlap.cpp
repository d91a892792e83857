#include "mesh/triangle_overlap.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/exact_sign.hpp"

namespace isoextract::mesh {
namespace {

using Signs = std::array<int, 3>;

// Returns on which side of the plane of p each corner of q lies.
Signs sides_of(const PlacedTriangle& p, const PlacedTriangle& q) {
  Signs signs;
  for (std::size_t i = 0; i < 3; ++i) {
    signs[i] = orientation_3d(p.corners[0], p.corners[1], p.corners[2], q.corners[i]);
  }
  return signs;
}

bool has_both(int a, int b, int c) { return std::min({a, b, c}) < 0 && std::max({a, b, c}) > 0; }

// Returns an axis along which the triangle's projection has area: the axis of the normal's largest component, or
// another axis if rounding misjudged this component.
int axis_of(const PlacedTriangle& t) {
  const glm::dvec3 normal = glm::abs(glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]));
  const int likely = normal.x >= normal.y && normal.x >= normal.z ? 0 : normal.y >= normal.z ? 1 : 2;
  for (int i = 0; i < 3; ++i) {
    const int axis = (likely + i) % 3;
    if (orientation_2d(along_axis(t.corners[0], axis), along_axis(t.corners[1], axis),
                       along_axis(t.corners[2], axis)) != 0) {
      return axis;
    }
  }
  return likely;
}

using Flat = std::array<glm::dvec2, 3>;

bool holds_point(const Flat& t, const glm::dvec2& p) {
  return !has_both(orientation_2d(t[0], t[1], p), orientation_2d(t[1], t[2], p), orientation_2d(t[2], t[0], p));
}

bool intervals_meet(double a, double b, double c, double d) {
  return std::max(std::min(a, b), std::min(c, d)) <= std::min(std::max(a, b), std::max(c, d));
}

bool segments_meet(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
  if (!intervals_meet(a.x, b.x, c.x, d.x) || !intervals_meet(a.y, b.y, c.y, d.y)) return false;
  // For four collinear points the intervals decide.
  return orientation_2d(a, b, c) * orientation_2d(a, b, d) <= 0 &&
         orientation_2d(c, d, a) * orientation_2d(c, d, b) <= 0;
}

// Segment and triangle lie in one plane.
bool flat_segment_meets(const glm::dvec3& a, const glm::dvec3& b, const PlacedTriangle& t) {
  const int axis = axis_of(t);
  const Flat flat{along_axis(t.corners[0], axis), along_axis(t.corners[1], axis), along_axis(t.corners[2], axis)};
  const glm::dvec2 p = along_axis(a, axis);
  const glm::dvec2 q = along_axis(b, axis);
  return holds_point(flat, p) || segments_meet(p, q, flat[0], flat[1]) || segments_meet(p, q, flat[1], flat[2]) ||
         segments_meet(p, q, flat[2], flat[0]);
}

// `at_a` and `at_b` are the sides of the triangle's plane on which the ends lie.
bool segment_meets(const glm::dvec3& a, const glm::dvec3& b, int at_a, int at_b, const PlacedTriangle& t) {
  if (at_a * at_b > 0) return false;
  if (at_a == 0 && at_b == 0) return flat_segment_meets(a, b, t);
  const auto& [x, y, z] = t.corners;
  return !has_both(orientation_3d(a, b, x, y), orientation_3d(a, b, y, z), orientation_3d(a, b, z, x));
}

bool all_zero(const Signs& signs) { return signs == Signs{}; }
bool on_one_side(const Signs& signs) {
  return std::min({signs[0], signs[1], signs[2]}) > 0 || std::max({signs[0], signs[1], signs[2]}) < 0;
}

// Returns whether a side of q meets p.
bool any_side_meets(const PlacedTriangle& p, const PlacedTriangle& q, const Signs& of_q) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t next = (i + 1) % 3;
    if (segment_meets(q.corners[i], q.corners[next], of_q[i], of_q[next], p)) return true;
  }
  return false;
}

TriangleOverlap overlap_of_disjoint(const PlacedTriangle& p, const PlacedTriangle& q) {
  const Signs of_q = sides_of(p, q);
  if (on_one_side(of_q)) return {};
  const Signs of_p = sides_of(q, p);
  if (on_one_side(of_p)) return {};
  TriangleOverlap overlap;
  overlap.meet = any_side_meets(p, q, of_q) || any_side_meets(q, p, of_p);
  overlap.in_one_plane = all_zero(of_q);
  return overlap;
}

// `at_p` and `at_q` are the corner numbers of the shared corner.
TriangleOverlap overlap_at_corner(const PlacedTriangle& p, const PlacedTriangle& q, std::size_t at_p,
                                  std::size_t at_q) {
  const glm::dvec3& p1 = p.corners[(at_p + 1) % 3];
  const glm::dvec3& p2 = p.corners[(at_p + 2) % 3];
  const glm::dvec3& q1 = q.corners[(at_q + 1) % 3];
  const glm::dvec3& q2 = q.corners[(at_q + 2) % 3];
  const auto side = [](const PlacedTriangle& t, const glm::dvec3& point) {
    return orientation_3d(t.corners[0], t.corners[1], t.corners[2], point);
  };
  const int of_q1 = side(p, q1);
  const int of_q2 = side(p, q2);
  if (of_q1 * of_q2 > 0) return {};
  const int of_p1 = side(q, p1);
  const int of_p2 = side(q, p2);
  if (of_p1 * of_p2 > 0) return {};
  TriangleOverlap overlap;
  overlap.meet = segment_meets(q1, q2, of_q1, of_q2, p) || segment_meets(p1, p2, of_p1, of_p2, q);
  overlap.in_one_plane = of_q1 == 0 && of_q2 == 0;
  overlap.neighbors = true;
  return overlap;
}

// `at_p` and `at_q` are the corner numbers of the corners that are not shared.
TriangleOverlap overlap_along_side(const PlacedTriangle& p, const PlacedTriangle& q, std::size_t at_p,
                                   std::size_t at_q) {
  const glm::dvec3& a = p.corners[(at_p + 1) % 3];
  const glm::dvec3& b = p.corners[(at_p + 2) % 3];
  const glm::dvec3& tip = p.corners[at_p];
  const glm::dvec3& other = q.corners[at_q];
  if (orientation_3d(a, b, tip, other) != 0) return {};
  const int axis = axis_of(p);
  const auto turn = [&](const glm::dvec3& c) {
    return orientation_2d(along_axis(a, axis), along_axis(b, axis), along_axis(c, axis));
  };
  const bool meet = turn(tip) == turn(other);
  return {meet, meet, meet};
}

}  // namespace

TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q) {
  std::array<std::size_t, 2> corner_of_p{};
  std::array<std::size_t, 2> corner_of_q{};
  std::size_t shared = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (shared == 2 || p.corners[i] != q.corners[j]) continue;
      corner_of_p[shared] = i;
      corner_of_q[shared] = j;
      ++shared;
    }
  }
  if (shared == 0) return overlap_of_disjoint(p, q);
  if (shared == 1) return overlap_at_corner(p, q, corner_of_p[0], corner_of_q[0]);
  return overlap_along_side(p, q, 3 - corner_of_p[0] - corner_of_p[1], 3 - corner_of_q[0] - corner_of_q[1]);
}

}  // namespace isoextract::mesh

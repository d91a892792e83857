// Decides whether two triangles intersect beyond the corners that they share, by another method than the program's:
// clips one triangle by the other in rational numbers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::test {

using WholeTriangle = std::array<glm::i64vec3, 3>;  // coordinates up to some hundreds, so that nothing overflows

class ExactOverlap {
 public:
  // Both triangles have an area and share at most two corners.
  static bool meet(const WholeTriangle& p, const WholeTriangle& q) {
    std::vector<Point> common;
    for (const glm::i64vec3& corner : p) common.push_back({corner.x, corner.y, corner.z, 1});
    const glm::i64vec3 normal = cross(q[1] - q[0], q[2] - q[0]);
    common = cut(common, normal, q[0]);
    common = cut(common, -normal, q[0]);
    for (std::size_t i = 0; i < 3; ++i) common = cut(common, cross(normal, q[(i + 1) % 3] - q[i]), q[i]);
    std::vector<glm::i64vec3> shared;
    for (const glm::i64vec3& corner : p) {
      if (corner == q[0] || corner == q[1] || corner == q[2]) shared.push_back(corner);
    }
    if (shared.empty()) return !common.empty();
    for (const Point& point : common) {
      if (shared.size() == 1 ? !is_at(point, shared[0]) : !is_on_line(point, shared[0], shared[1])) return true;
    }
    return false;
  }

 private:
  __extension__ using Whole = __int128;
  struct Point {  // the point (x / w, y / w, z / w) with w > 0
    Whole x, y, z, w;
  };

  static glm::i64vec3 cross(const glm::i64vec3& a, const glm::i64vec3& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }

  static Whole divisor(Whole a, Whole b) {
    a = a < 0 ? -a : a;
    b = b < 0 ? -b : b;
    while (b != 0) {
      const Whole rest = a % b;
      a = b;
      b = rest;
    }
    return a;
  }

  static Point reduced(Point p) {
    Whole by = divisor(divisor(p.x, p.y), divisor(p.z, p.w));
    if (p.w < 0) by = -by;
    return {p.x / by, p.y / by, p.z / by, p.w / by};
  }

  // Returns the signed distance from the plane through `at`, times w.
  static Whole height(const Point& p, const glm::i64vec3& normal, const glm::i64vec3& at) {
    return normal.x * (p.x - at.x * p.w) + normal.y * (p.y - at.y * p.w) + normal.z * (p.z - at.z * p.w);
  }

  // Returns the part of a convex polygon that is not below the plane. The polygon may be a segment or a point.
  static std::vector<Point> cut(const std::vector<Point>& polygon, const glm::i64vec3& normal, const glm::i64vec3& at) {
    std::vector<Point> kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Point& a = polygon[i];
      const Point& b = polygon[(i + 1) % polygon.size()];
      const Whole of_a = height(a, normal, at);
      const Whole of_b = height(b, normal, at);
      if (of_a >= 0) kept.push_back(a);
      if ((of_a < 0 && of_b > 0) || (of_a > 0 && of_b < 0)) {
        kept.push_back(reduced(
            {of_b * a.x - of_a * b.x, of_b * a.y - of_a * b.y, of_b * a.z - of_a * b.z, of_b * a.w - of_a * b.w}));
      }
    }
    return kept;
  }

  static bool is_at(const Point& p, const glm::i64vec3& at) {
    return p.x == at.x * p.w && p.y == at.y * p.w && p.z == at.z * p.w;
  }

  static bool is_on_line(const Point& p, const glm::i64vec3& a, const glm::i64vec3& b) {
    const glm::i64vec3 way = b - a;
    const Whole x = p.x - a.x * p.w;
    const Whole y = p.y - a.y * p.w;
    const Whole z = p.z - a.z * p.w;
    return y * way.z == z * way.y && z * way.x == x * way.z && x * way.y == y * way.x;
  }
};

}  // namespace isoextract::test

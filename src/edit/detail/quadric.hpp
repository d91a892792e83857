// Weighted squared distances to planes (Garland, Heckbert: Surface simplification using quadric error metrics.
// SIGGRAPH 1997).
#pragma once

#include <algorithm>

#include <glm/glm.hpp>

namespace isoextract::edit {

// The weighted sum of squared distances to planes, p^T A p + 2 b^T p + c, and the sum of the weights.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  glm::dvec3 b{0.0};
  double c = 0;
  double weight = 0;

  void add_plane(const glm::dvec3& normal, const glm::dvec3& point, double area) {
    const double d = -glm::dot(normal, point);
    xx += area * normal.x * normal.x;
    xy += area * normal.x * normal.y;
    xz += area * normal.x * normal.z;
    yy += area * normal.y * normal.y;
    yz += area * normal.y * normal.z;
    zz += area * normal.z * normal.z;
    b += area * d * normal;
    c += area * d * d;
    weight += area;
  }
  void add(const Quadric& other) {
    xx += other.xx;
    xy += other.xy;
    xz += other.xz;
    yy += other.yy;
    yz += other.yz;
    zz += other.zz;
    b += other.b;
    c += other.c;
    weight += other.weight;
  }
  [[nodiscard]] double sum_at(const glm::dvec3& p) const {
    const glm::dvec3 a(xx * p.x + xy * p.y + xz * p.z, xy * p.x + yy * p.y + yz * p.z, xz * p.x + yz * p.y + zz * p.z);
    return glm::dot(p, a) + 2 * glm::dot(b, p) + c;
  }
};

// Returns the weighted mean squared distance of p to the planes of a and b.
[[nodiscard]] inline double mean_square(const Quadric& a, const Quadric& b, const glm::dvec3& p) {
  const double weight = a.weight + b.weight;
  return weight > 0 ? std::max(a.sum_at(p) + b.sum_at(p), 0.0) / weight : 0;
}

}  // namespace isoextract::edit

// The closest point of a triangle.
#pragma once

#include <glm/glm.hpp>

namespace isoextract {

// The point of the triangle a, b, c, which may be without area, that is closest to `p`. In double.
//
// By the Voronoi regions of the corners and edges: Ericson, Real-Time Collision Detection (2005), section 5.1.5. An
// edge without length has no region of its own.
[[nodiscard]] inline glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b,
                                                    const glm::dvec3& c) {
  const glm::dvec3 ab = b - a;
  const glm::dvec3 ac = c - a;
  const glm::dvec3 ap = p - a;
  const double d1 = glm::dot(ab, ap);
  const double d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const glm::dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp);
  const double d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + d1 / (d1 - d3) * ab;
  const glm::dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp);
  const double d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  const double to_c = d4 - d3;
  const double to_b = d5 - d6;
  if (va <= 0 && to_c >= 0 && to_b >= 0 && to_c + to_b > 0) return b + to_c / (to_c + to_b) * (c - b);
  const double sum = va + vb + vc;
  return a + vb / sum * ab + vc / sum * ac;
}

}  // namespace isoextract

// Points inside triangles, to integrate over them.
#pragma once

#include <array>

#include <glm/glm.hpp>

namespace isoextract::measure {

struct TrianglePoint {
  glm::dvec3 weights;  // barycentric: of the three corners
  double share;        // of the triangle's area

  [[nodiscard]] glm::dvec3 in(const std::array<glm::dvec3, 3>& corners) const {
    return weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
  }
};

// Radon's rule, exact to degree five: "Zur mechanischen Kubatur", Monatshefte fuer Mathematik 52, 1948. All points are
// inside, and one is the centroid, where a flat triangle on a curved surface is most wrong.
inline constexpr std::array<TrianglePoint, 7> kTrianglePoints = [] {
  constexpr double kRoot15 = 3.87298334620741688517926539978;
  std::array<TrianglePoint, 7> points{};
  points[0] = {glm::dvec3(1.0 / 3, 1.0 / 3, 1.0 / 3), 9.0 / 40};
  std::size_t next = 1;
  for (const double sign : {1.0, -1.0}) {
    const double same = (6 - sign * kRoot15) / 21;
    const double other = 1 - 2 * same;
    const double share = (155 - sign * kRoot15) / 1200;
    points[next++] = {glm::dvec3(other, same, same), share};
    points[next++] = {glm::dvec3(same, other, same), share};
    points[next++] = {glm::dvec3(same, same, other), share};
  }
  return points;
}();

}  // namespace isoextract::measure

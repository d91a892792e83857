// Integration points inside triangles.
#pragma once

#include <array>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

struct TrianglePoint {
  glm::dvec3 weights;  // barycentric
  double share;        // fraction of the triangle's area

  [[nodiscard]] glm::dvec3 in(const std::array<glm::dvec3, 3>& corners) const {
    return weights.x * corners[0] + weights.y * corners[1] + weights.z * corners[2];
  }
};

// Radon's rule, exact to degree five: "Zur mechanischen Kubatur", Monatshefte fuer Mathematik 52, 1948. All points are
// inside; one is the centroid, where a flat triangle on a curved surface has its largest error.
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

// The longest side, in voxels, of a triangle that is not divided. Triangles of marching cubes have no longer sides.
inline constexpr double kLongestSide = 1.75;

// A part of a triangle.
struct TrianglePart {
  // Barycentric coordinates of the part's corners.
  std::array<glm::dvec3, 3> weights{glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, 0, 1)};
  double share = 1;
};

// Calls take(point) for kTrianglePoints of each part of a triangle. Parts are halved across their longest side until no
// side is longer than `longest`. Shares and weights refer to the whole triangle. Skips a part, with all parts of it, if
// is_wanted(low, high) returns false for its bounding box.
template <class IsWanted, class Take>
void for_each_wanted_point(const std::array<glm::dvec3, 3>& corners, double longest, const IsWanted& is_wanted,
                           const Take& take, const TrianglePart& part = {}) {
  const auto place = [&](std::size_t corner) { return TrianglePoint{part.weights[corner], 1}.in(corners); };
  const std::array places{place(0), place(1), place(2)};
  const glm::dvec3 low = glm::min(places[0], glm::min(places[1], places[2]));
  const glm::dvec3 high = glm::max(places[0], glm::max(places[1], places[2]));
  if (!is_wanted(low, high)) return;
  std::size_t from = 0;
  double squared = 0;
  for (std::size_t side = 0; side < 3; ++side) {
    const glm::dvec3 along = places[(side + 1) % 3] - places[side];
    if (glm::dot(along, along) <= squared) continue;
    from = side;
    squared = glm::dot(along, along);
  }
  if (!(squared > longest * longest)) {
    for (const TrianglePoint& point : kTrianglePoints)
      take(TrianglePoint{point.in(part.weights), point.share * part.share});
    return;
  }
  const glm::dvec3& a = part.weights[from];
  const glm::dvec3& b = part.weights[(from + 1) % 3];
  const glm::dvec3& c = part.weights[(from + 2) % 3];
  const glm::dvec3 middle = 0.5 * (a + b);
  for_each_wanted_point(corners, longest, is_wanted, take, {{a, middle, c}, part.share / 2});
  for_each_wanted_point(corners, longest, is_wanted, take, {{middle, b, c}, part.share / 2});
}

// Does so for all parts.
template <class Take>
void for_each_point(const std::array<glm::dvec3, 3>& corners, double longest, const Take& take) {
  const auto all = [](const glm::dvec3& /*low*/, const glm::dvec3& /*high*/) { return true; };
  for_each_wanted_point(corners, longest, all, take);
}

}  // namespace isoextract::accuracy

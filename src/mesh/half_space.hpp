// The half-space on one side of a plane.
#pragma once

#include <glm/glm.hpp>

namespace isoextract::mesh {

// The points p with dot(normal, p) >= offset.
struct HalfSpace {
  glm::dvec3 normal{0, 0, 1};  // unit length; points into the half-space
  double offset = 0;

  // Returns the distance of p from the plane; negative outside.
  [[nodiscard]] double depth(const glm::dvec3& p) const { return glm::dot(normal, p) - offset; }
};

// Returns the distance below which a vertex counts as on a cutting plane: a few rounding errors of float32 positions
// whose greatest absolute coordinate is `farthest`. If a second plane cuts triangles that lie in the first, the new
// vertices may be up to twice this distance from the first plane.
[[nodiscard]] inline double on_plane_tolerance(float farthest) {
  constexpr double kRoundings = 4;
  return kRoundings * 0x1p-23 * static_cast<double>(farthest);
}

}  // namespace isoextract::mesh

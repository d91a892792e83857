// One side of a plane.
#pragma once

#include <glm/glm.hpp>

namespace isoextract::mesh {

// The points p with dot(normal, p) >= offset.
struct HalfSpace {
  glm::dvec3 normal{0, 0, 1};  // of unit length; it points into the half-space
  double offset = 0;

  // How far p is within; below 0 outside.
  [[nodiscard]] double depth(const glm::dvec3& p) const { return glm::dot(normal, p) - offset; }
};

// Vertices that are nearer to a plane than this count as on it where it cuts: a few roundings of float32 positions, of
// whose coordinates `farthest` is the greatest. Where a later plane cut what lies in it, they may be twice as far.
[[nodiscard]] inline double on_plane_distance(float farthest) {
  constexpr double kRoundings = 4;
  return kRoundings * 0x1p-23 * static_cast<double>(farthest);
}

}  // namespace isoextract::mesh

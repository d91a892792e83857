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

}  // namespace isoextract::mesh

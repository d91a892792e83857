// The origin that a mesh's float32 positions are relative to.
#pragma once

#include <glm/glm.hpp>

namespace isoextract::mesh {

// Returns the origin for coordinates between `min` and `max`: zero if float32 then loses at most two bits on every axis
// compared with coordinates relative to the center; else the center.
[[nodiscard]] inline glm::dvec3 choose_local_origin(const glm::dvec3& min, const glm::dvec3& max) {
  const glm::dvec3 farthest = glm::max(glm::abs(min), glm::abs(max));
  const glm::dvec3 half_extent = (max - min) / 2.0;
  constexpr double kNear = 4;
  const bool near = glm::all(glm::lessThanEqual(farthest, kNear * half_extent));
  return near ? glm::dvec3(0) : min / 2.0 + max / 2.0;
}

}  // namespace isoextract::mesh

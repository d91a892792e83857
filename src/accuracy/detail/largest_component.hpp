// Measures the size of a gradient without squares, which may leave the range of double.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

// Returns the largest absolute component.
[[nodiscard]] inline double max_abs_component(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace isoextract::accuracy

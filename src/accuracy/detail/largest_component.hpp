// The size of gradients before they are scaled: their squares may leave the range of double.
#pragma once

#include <algorithm>
#include <cmath>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

// Of the absolute components.
[[nodiscard]] inline double largest_component(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace isoextract::accuracy

// Tests for numbers that are neither infinite nor NaN.
#pragma once

#include <cmath>

#include <glm/glm.hpp>

namespace isoextract {

[[nodiscard]] inline bool is_finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace isoextract

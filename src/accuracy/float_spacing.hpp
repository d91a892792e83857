// The spacing of float32 numbers. At a point it is widest along the axis of the largest absolute coordinate.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/glm.hpp>

namespace isoextract::accuracy {

// Returns the distance from the float32 number `size` (finite, not negative) to the next larger one.
[[nodiscard]] inline double float_spacing(double size) {
  constexpr int kDigits = std::numeric_limits<float>::digits;
  constexpr int kLowest = std::numeric_limits<float>::min_exponent - 1;  // subnormal numbers keep this spacing
  const int exponent = size > 0 ? std::ilogb(size) : kLowest;
  return std::ldexp(1.0, std::max(exponent, kLowest) - (kDigits - 1));
}

// Returns the largest absolute coordinate: float_spacing() of it is the widest spacing at the point.
[[nodiscard]] inline double max_abs_coordinate(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace isoextract::accuracy

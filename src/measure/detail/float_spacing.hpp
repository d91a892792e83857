// How far apart float32 numbers are.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace isoextract::measure {

// From the float32 number `size` (not negative, finite) to the next larger one.
[[nodiscard]] inline double float_spacing(double size) {
  constexpr int kDigits = std::numeric_limits<float>::digits;
  constexpr int kLowest = std::numeric_limits<float>::min_exponent - 1;  // subnormal numbers keep this spacing
  const int exponent = size > 0 ? std::ilogb(size) : kLowest;
  return std::ldexp(1.0, std::max(exponent, kLowest) - (kDigits - 1));
}

}  // namespace isoextract::measure

// Finds a zero of a function of one variable.
#pragma once

#include <algorithm>
#include <cmath>

namespace isoextract::accuracy {

// Returns a zero of `at` between a and b. The values value_a = at(a) and value_b = at(b) have different signs. Uses
// regula falsi with the Illinois rule (Dowell and Jarratt, "A modified regula falsi method", BIT 11, 1971). Stops if
// |at(x)| <= `enough`, if the interval is at most 1e-9 |x| long, if at(x) is not finite, or after 100 rounds.
template <class F>
[[nodiscard]] double find_crossing(const F& at, double a, double value_a, double b, double value_b, double enough) {
  for (int round = 0; round < 100; ++round) {
    const double c = b - value_b * ((b - a) / (value_b - value_a));
    if (!(c > std::min(a, b) && c < std::max(a, b))) return b;
    const double value_c = at(c);
    if (std::abs(value_c) <= enough || !std::isfinite(value_c)) return c;
    if ((value_c > 0) != (value_b > 0)) {
      a = b;
      value_a = value_b;
    } else {
      value_a /= 2;
    }
    b = c;
    value_b = value_c;
    if (std::abs(b - a) <= 1e-9 * std::abs(b)) return b;
  }
  return b;
}

}  // namespace isoextract::accuracy

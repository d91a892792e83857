// The cubic spline kernel of smoothed particle hydrodynamics in three dimensions.
//
// J. J. Monaghan: Smoothed particle hydrodynamics. Annu. Rev. Astron. Astrophys. 30, 1992, section 2.1. Written in q =
// distance / support, where the support is twice the smoothing length:
//   W = 8 / (pi support^3) S(q),   S(q) = 1 - 6 q^2 + 6 q^3 up to 1/2, 2 (1 - q)^3 up to 1, 0 beyond.
#pragma once

#include <algorithm>

namespace isoextract::points {

// Returns S(q) for q >= 0; S(0) = 1. Uses 2 max(0, 1 - q)^3 - max(0, 1 - 2q)^3, which is equal and has no branch.
template <class T>
[[nodiscard]] constexpr T spline_shape(T q) {
  const T outer = std::max(T(0), T(1) - q);
  const T inner = std::max(T(0), outer + outer - T(1));
  return T(2) * outer * outer * outer - inner * inner * inner;
}

}  // namespace isoextract::points

// Conversion between sRGB and linear light (IEC 61966-2-1). glTF stores vertex and material colors in linear light, and
// all computations here use it.
#pragma once

#include <cmath>

namespace isoextract {

// Both functions convert one channel in [0, 1].
[[nodiscard]] inline double srgb_to_linear(double channel) {
  return channel <= 0.04045 ? channel / 12.92 : std::pow((channel + 0.055) / 1.055, 2.4);
}
[[nodiscard]] inline double linear_to_srgb(double channel) {
  return channel <= 0.0031308 ? channel * 12.92 : 1.055 * std::pow(channel, 1 / 2.4) - 0.055;
}

}  // namespace isoextract

// Which samples are labels: all integers, and floating-point samples that are whole numbers.
#pragma once

#include <cmath>
#include <type_traits>

#include "field/sample_type.hpp"

namespace isoextract::field {

// Returns the largest label that a floating-point type T can hold. Beyond 2^digits, its numbers are farther apart than
// 1, so two labels may have become one when the file was written.
template <class T>
[[nodiscard]] constexpr double largest_label() {
  if constexpr (std::is_same_v<T, Half>) return 0x1p11;
  if constexpr (std::is_same_v<T, float>) return 0x1p24;
  return 0x1p53;
}

template <class T>
[[nodiscard]] bool is_label(T sample) {
  if constexpr (is_floating_sample<T>) {
    const auto value = static_cast<double>(sample);
    return std::abs(value) <= largest_label<T>() && value == std::floor(value);
  } else {
    return true;
  }
}

}  // namespace isoextract::field

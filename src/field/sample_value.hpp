// Conversion of values back to samples.
#pragma once

#include <type_traits>

#include "field/sample_type.hpp"

namespace isoextract::field {

// Converts a value, such as a background, to the sample type T. T must represent it exactly or be a floating-point
// type.
template <class T>
[[nodiscard]] T to_sample(double value) {
  if constexpr (std::is_same_v<T, Half>) {
    return Half(static_cast<float>(value));
  } else {
    return static_cast<T>(value);
  }
}

}  // namespace isoextract::field

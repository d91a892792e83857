// From values back to samples.
#pragma once

#include <type_traits>

#include "field/sample_type.hpp"

namespace isoextract::field {

// The sample that a field holds as `value`, such as a background. `value` is one that T has, or T is floating.
template <class T>
[[nodiscard]] T sample_from(double value) {
  if constexpr (std::is_same_v<T, Half>) {
    return Half(static_cast<float>(value));
  } else {
    return static_cast<T>(value);
  }
}

}  // namespace isoextract::field

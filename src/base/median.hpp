// The median; for an even number of values, the mean of the middle two.
#pragma once

#include <algorithm>
#include <vector>

namespace isoextract {

// Requires at least one value.
[[nodiscard]] inline double median(std::vector<double> values) {
  std::ranges::sort(values);
  const std::size_t half = values.size() / 2;
  return values.size() % 2 != 0 ? values[half] : (values[half - 1] + values[half]) / 2;
}

}  // namespace isoextract

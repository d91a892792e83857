// Counts each value of a small sample type.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "field/detail/sample_passes.hpp"
#include "field/percentiles.hpp"

namespace isoextract::field {

// Whether a type has few enough values to count each of them.
template <class T>
inline constexpr bool kIsCountable = sizeof(T) <= 2;

// A value and its number of samples.
using CountedValue = std::pair<double, std::uint64_t>;

template <class T>
class Tally {
 public:
  Tally(const ScalarField& field, Progress* progress) {
    counts_ = count_samples<T>(
        field, kNumbers,
        [](std::vector<std::uint64_t>& counts, std::span<const T> values) {
          for (const T value : values) ++counts[std::bit_cast<Bits>(value)];
        },
        progress);
    for_each_tile(field, [&](double value, std::uint64_t voxels) {
      counts_[std::bit_cast<Bits>(static_cast<T>(static_cast<WorkOf>(value)))] += voxels;
    });
  }

  // Returns each value that occurs, scaled.
  [[nodiscard]] std::vector<CountedValue> values(const ValueScale& scale) const {
    std::vector<CountedValue> values;
    for (std::size_t bits = 0; bits < kNumbers; ++bits) {
      if (counts_[bits] == 0) continue;
      const auto stored = static_cast<double>(std::bit_cast<T>(static_cast<Bits>(bits)));
      values.emplace_back(scale(stored), counts_[bits]);
    }
    return values;
  }

 private:
  using Bits = std::conditional_t<sizeof(T) == 1, std::uint8_t, std::uint16_t>;
  using WorkOf = std::conditional_t<std::is_integral_v<T>, T, float>;
  static constexpr std::size_t kNumbers = std::size_t{1} << (8 * sizeof(T));
  std::vector<std::uint64_t> counts_;
};

// Removes values that are not finite and sorts the rest.
inline void keep_finite_sorted(std::vector<CountedValue>& values) {
  std::erase_if(values, [](const CountedValue& value) { return !std::isfinite(value.first); });
  std::ranges::sort(values);
}

// Returns the percentiles of sorted values with `samples` counts in total. `percents` must ascend.
[[nodiscard]] std::vector<double> percentiles_of(std::span<const CountedValue> values, std::uint64_t samples,
                                                 std::span<const Percent> percents);

// Returns the percentiles of a field with `samples` >= 1 finite samples of a type that is not countable. `percents`
// must ascend.
[[nodiscard]] std::vector<double> percentiles_of(const ScalarField& field, std::uint64_t samples,
                                                 std::span<const Percent> percents, Progress* progress);

}  // namespace isoextract::field

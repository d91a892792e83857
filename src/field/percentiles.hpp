// Exact percentiles of a field's samples: each is one of the samples (nearest rank).
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/progress.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// A share from 0 to 100 %, stored as a decimal: 99.9 has no exact binary fraction, and rounding must not select another
// sample.
class Percent {
 public:
  static constexpr int kDecimals = 6;  // the most decimal places

  constexpr Percent() = default;
  constexpr explicit Percent(std::uint32_t whole) : parts_(whole * kPart) {}  // 0 to 100

  // Parses digits with an optional decimal point: "99", "0.5". Returns nothing for any other text, for too many decimal
  // places and for more than 100.
  [[nodiscard]] static std::optional<Percent> parse(std::string_view text);
  [[nodiscard]] std::string text() const;  // without trailing zeros

  // Returns the index, in the sorted list of `samples` (at least 1) samples, of the smallest sample s such that at
  // least this share of all samples is <= s. 0 % gives the first sample.
  [[nodiscard]] std::uint64_t rank_among(std::uint64_t samples) const;

  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const Percent&, const Percent&) = default;

 private:
  static constexpr std::uint32_t kPart = 1'000'000;  // 10^kDecimals
  std::uint32_t parts_ = 0;
};

// Returns the percentiles `percents` of the scaled samples, in the order of `percents`. Counts the samples that
// FieldStatistics::samples counts. Returns nothing if no sample is finite.
[[nodiscard]] std::optional<std::vector<double>> measure_percentiles(const ScalarField& field,
                                                                     std::span<const Percent> percents,
                                                                     Progress* progress = nullptr);

// Returns the most bytes, over all threads of the task arena, that measure_percentiles() takes for that many
// percentiles. Also the most that measure_statistics() takes with WithPercentiles::no. The caller reserves them.
[[nodiscard]] std::uint64_t statistics_bytes(std::size_t percents);

}  // namespace isoextract::field

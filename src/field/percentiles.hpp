// Percentiles of a field's samples, exact: each is one of the samples.
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

// A share from 0 to 100 %, as a decimal: 99.9 is no binary fraction, and rounding must not choose another sample.
class Percent {
 public:
  static constexpr int kDecimals = 6;  // that it can have

  constexpr Percent() = default;
  constexpr explicit Percent(std::uint32_t whole) : parts_(whole * kPart) {}  // 0..100

  // Of digits, with a point or without: "99", "0.5". Nothing for other texts, more decimals, and more than 100.
  [[nodiscard]] static std::optional<Percent> parse(std::string_view text);
  [[nodiscard]] std::string text() const;  // without zeros that say nothing

  // How many of so many ordered samples, at least one, come before the percentile: the least that this share of them
  // does not exceed; of 0 % the first.
  [[nodiscard]] std::uint64_t rank_among(std::uint64_t samples) const;

  // NOLINTNEXTLINE(modernize-use-nullptr): there is none
  friend auto operator<=>(const Percent&, const Percent&) = default;

 private:
  static constexpr std::uint32_t kPart = 1'000'000;  // 10^kDecimals
  std::uint32_t parts_ = 0;
};

// By `percents`: the samples that these are, of those that FieldStatistics counts, and scaled as there. Nothing where
// no sample is finite.
[[nodiscard]] std::optional<std::vector<double>> measure_percentiles(const ScalarField& field,
                                                                     std::span<const Percent> percents,
                                                                     Progress* progress = nullptr);

// The most memory that this takes while it works, and measure_statistics() without percentiles, on all threads.
[[nodiscard]] std::uint64_t measuring_bytes(std::size_t percents);

}  // namespace isoextract::field

// Names that differ in a decimal number, as solvers write times: t_0.25.npy, t_0.5.npy, t_1e-3.npy. A comma or a p may
// stand for the point (t_0,25, t_0p25), and the digit before the point may be missing (t_.25).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "files/frame_pattern.hpp"

namespace isoextract::batch {

struct DecimalOrder {
  std::vector<std::size_t> names;  // by rising value; equal values in natural order
  // The numbers may be two whole numbers, shot and frame (1.0001, 2.0001): all have the same number of digits after the
  // point.
  bool may_be_two_numbers = false;
};

// Orders names that are equal except for one decimal number: digits, optional fraction, optional signed exponent
// (1.5e-03).
//
// Returns nullopt if the names differ elsewhere, if no number has a fraction or an exponent, or if double cannot hold a
// value. Also returns nullopt if all numbers have a fraction, none has an exponent, none is a negative zero, and one of
// these conditions holds:
//   - only the digits before the point differ;
//   - only the digits after the point differ, and all have the same length;
//   - the digits after the point have several lengths, and judge_fractions() does not call them fractions.
[[nodiscard]] std::optional<DecimalOrder> order_by_decimals(std::span<const std::string> names);

// Returns whether the name has a number with a fraction or an exponent (0.25, .25, -0p5, 1e-3) where the pattern has
// its whole number.
[[nodiscard]] bool has_decimal_number(const files::FramePattern& pattern, std::string_view name);

// How to read the digits after a point.
enum class FractionKind {
  whole_numbers,  // whole numbers: all of one length, or without leading zeros and consecutive: 8, 9, 10
  fractions,      // fractions: 25, 5, 75
  // Lengths differ; one number ends in 0, or steps are equal except for gaps: 5, 10, 25; 5, 25, 45; 98, 99, 101.
  unclear,
};
[[nodiscard]] FractionKind judge_fractions(std::span<const std::string_view> digits);

// Returns whether a number that follows `prefix` is part of a decimal number: after "0.", "0p" or "1e-".
[[nodiscard]] bool ends_within_decimal(std::string_view prefix);
[[nodiscard]] bool ends_in_exponent(std::string_view prefix);

}  // namespace isoextract::batch

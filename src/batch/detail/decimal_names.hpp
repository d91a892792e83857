// Names that differ in a decimal number, as solvers write times: t_0.25.npy, t_0.5.npy, t_1e-3.npy. The point may be a
// comma or a p as well (t_0,25, t_0p25), and needs no digit before it (t_.25).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isoextract::batch {

struct DecimalOrder {
  std::vector<std::size_t> names;  // by rising value, equal ones in natural order
  // The numbers may be a shot and a frame as well (1.0001, 2.0001): all have as many digits after the point.
  bool may_be_two_numbers = false;
};

// Orders names that are equal except for one decimal number. A number has digits, a fraction and an exponent with its
// sign (1.5e-03), both optional. Nothing where another difference exists, where no number has a fraction or an
// exponent, and where whole numbers order the names as well: before or after the point all digits are the same, and
// those that differ are whole numbers by judge_fractions().
[[nodiscard]] std::optional<DecimalOrder> order_by_decimals(std::span<const std::string> names);

// Says how to read the digits after a point.
enum class FractionKind {
  whole_numbers,  // of one length, or without zeros to fill them and each one more than the last: 8, 9, 10
  fractions,      // 25, 5, 75
  // Of several lengths, and at least one ends in 0, or steps are equal, gaps apart: 5, 10, 25; 5, 25, 45; 98, 99, 101.
  unclear,
};
[[nodiscard]] FractionKind judge_fractions(std::span<const std::string_view> digits);

// Whether a number that follows `prefix` is a part of a decimal number: after "0.", "0p" or "1e-".
[[nodiscard]] bool ends_within_decimal(std::string_view prefix);
[[nodiscard]] bool ends_in_exponent(std::string_view prefix);

}  // namespace isoextract::batch

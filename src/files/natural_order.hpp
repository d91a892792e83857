// Natural order of names: f2 before f10.
#pragma once

#include <compare>
#include <string_view>

namespace isoextract::files {

// Compares names, the same in every locale: digits as numbers of any length, everything else byte by byte. A total
// order: names that differ only in leading zeros of a number are adjacent, in byte order.
[[nodiscard]] std::strong_ordering natural_order(std::string_view a, std::string_view b);

struct NaturalLess {
  [[nodiscard]] bool operator()(std::string_view a, std::string_view b) const {
    return std::is_lt(natural_order(a, b));
  }
};

}  // namespace isoextract::files

// Names in the order in which people number them: f2 before f10.
#pragma once

#include <compare>
#include <string_view>

namespace isoextract::batch {

// A total order of names, the same in every locale: digits are compared as numbers of any length, everything else byte
// by byte. Names that differ only in zeros before a number are next to each other, in the order of their bytes.
[[nodiscard]] std::strong_ordering natural_order(std::string_view a, std::string_view b);

struct NaturalLess {
  [[nodiscard]] bool operator()(std::string_view a, std::string_view b) const {
    return std::is_lt(natural_order(a, b));
  }
};

}  // namespace isoextract::batch

#include "files/natural_order.hpp"

#include <algorithm>
#include <cstddef>

#include "base/ascii.hpp"

namespace isoextract::files {
namespace {

// Removes the leading digits from `text` and returns them without leading zeros.
std::string_view take_digits(std::string_view& text) {
  const std::string_view digits = text.substr(0, text.find_first_not_of(kDigits));
  text.remove_prefix(digits.size());
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

}  // namespace

std::strong_ordering natural_order(std::string_view a, std::string_view b) {
  std::string_view rest_of_a = a;
  std::string_view rest_of_b = b;
  while (!rest_of_a.empty() && !rest_of_b.empty()) {
    if (is_digit(rest_of_a.front()) && is_digit(rest_of_b.front())) {
      const std::string_view one = take_digits(rest_of_a);
      const std::string_view other = take_digits(rest_of_b);
      if (one.size() != other.size()) return one.size() <=> other.size();
      if (const int order = one.compare(other); order != 0) return order <=> 0;
    } else {
      const auto one = static_cast<unsigned char>(rest_of_a.front());
      const auto other = static_cast<unsigned char>(rest_of_b.front());
      if (one != other) return one <=> other;
      rest_of_a.remove_prefix(1);
      rest_of_b.remove_prefix(1);
    }
  }
  if (rest_of_a.empty() != rest_of_b.empty()) {
    return rest_of_a.empty() ? std::strong_ordering::less : std::strong_ordering::greater;
  }
  return a.compare(b) <=> 0;
}

}  // namespace isoextract::files

#include "batch/detail/decimal_names.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <numeric>
#include <system_error>
#include <tuple>
#include <utility>

#include "base/ascii.hpp"
#include "batch/detail/sequences.hpp"
#include "files/frame_pattern.hpp"
#include "files/natural_order.hpp"

namespace isoextract::batch {
namespace {

struct Decimal {
  std::string_view whole;  // may be empty, as in .25
  std::string_view fraction;
  std::string_view exponent;  // with its sign
  bool minus = false;
  bool may_be_hyphen = false;  // the minus follows a letter or digit, so it may be a hyphen

  [[nodiscard]] bool same(const Decimal& other) const {
    return std::tie(whole, fraction, exponent, minus) ==
           std::tie(other.whole, other.fraction, other.exponent, other.minus);
  }
  [[nodiscard]] bool is_minus_zero() const {
    return minus && whole.find_first_not_of('0') == std::string_view::npos && !fraction.empty();
  }
  // Returns nullopt if the number is out of double's range.
  [[nodiscard]] std::optional<double> value(bool with_sign) const {
    std::string text(with_sign && minus ? "-" : "");
    text += whole;
    if (!fraction.empty()) (text += '.') += fraction;
    if (!exponent.empty()) (text += 'e') += exponent;
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() ? std::optional(number) : std::nullopt;
  }
};

struct DecimalName {
  std::string skeleton;  // the name with a mark in place of each number
  std::vector<Decimal> numbers;
};

std::string_view digits_at(std::string_view name, std::size_t at) {
  return at >= name.size() ? std::string_view() : name.substr(at, name.find_first_not_of(kDigits, at) - at);
}

// Returns whether a decimal point may stand at `at`: 0.25, 0,25, 0p25, and .25 after one of kEndsOfWords.
bool is_decimal_point(std::string_view name, std::size_t at) {
  constexpr std::string_view kPoints(".,p");
  constexpr std::string_view kEndsOfWords("_-= ");
  if (at == 0 || at >= name.size()) return false;
  if (is_digit(name[at - 1])) return kPoints.find(name[at]) != std::string_view::npos;
  return name[at] == '.' && kEndsOfWords.find(name[at - 1]) != std::string_view::npos;
}

DecimalName split_decimals(std::string_view name) {
  DecimalName result;
  for (std::size_t at = 0; at < name.size();) {
    const std::string_view whole = digits_at(name, at);
    const bool starts_with_point = whole.empty() && is_decimal_point(name, at) && !digits_at(name, at + 1).empty();
    if (whole.empty() && !starts_with_point) {
      result.skeleton += name[at++];
      continue;
    }
    Decimal number{whole, {}, {}};
    number.minus = at > 0 && name[at - 1] == '-';
    if (number.minus) {
      result.skeleton.pop_back();
      number.may_be_hyphen = at > 1 && is_part_of_word(name[at - 2]);
    }
    at += whole.size();
    if (is_decimal_point(name, at)) number.fraction = digits_at(name, at + 1);
    if (!number.fraction.empty()) at += number.fraction.size() + 1;
    if (ends_in_exponent(name.substr(0, std::min(at + 2, name.size())))) {
      const std::string_view digits = digits_at(name, at + 2);
      if (!digits.empty()) number.exponent = name.substr(at + 1, digits.size() + 1);
      if (!digits.empty()) at += digits.size() + 2;
    }
    result.skeleton += kNumberMark;
    result.numbers.push_back(number);
  }
  return result;
}

// Returns the only number in which the names differ, one for each name; empty if there is no such number.
std::vector<Decimal> differing_numbers(std::span<const std::string> names) {
  std::vector<DecimalName> split;
  for (const std::string& name : names) {
    split.push_back(split_decimals(name));
    if (split.back().skeleton != split.front().skeleton) return {};
  }
  std::optional<std::size_t> place;
  for (std::size_t n = 0; n < split.front().numbers.size(); ++n) {
    const Decimal& first = split.front().numbers[n];
    if (std::ranges::all_of(split, [&](const DecimalName& name) { return name.numbers[n].same(first); })) continue;
    if (place) return {};
    place = n;
  }
  std::vector<Decimal> numbers;
  for (const DecimalName& name : split) {
    if (place) numbers.push_back(name.numbers[*place]);
  }
  return numbers;
}

enum class Steps {
  of_one,
  equal,
  with_gaps,  // multiples of the smallest step, with at least half of the numbers present
  unequal,
};

Steps steps_of(std::span<const std::string_view> digits) {
  std::vector<std::int64_t> numbers;
  for (const std::string_view text : digits) {
    if (text.size() > files::kMaxFrameDigits) return Steps::unequal;
    std::from_chars(text.data(), text.data() + text.size(), numbers.emplace_back());
  }
  if (numbers.size() < 3) return Steps::unequal;
  std::ranges::sort(numbers);
  std::int64_t least = numbers[1] - numbers[0];
  for (std::size_t i = 2; i < numbers.size(); ++i) least = std::min(least, numbers[i] - numbers[i - 1]);
  if (least == 0) return Steps::unequal;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if ((numbers[i] - numbers[i - 1]) % least != 0) return Steps::unequal;
  }
  const auto count = static_cast<std::int64_t>(numbers.size());
  const std::int64_t whole = (numbers.back() - numbers.front()) / least + 1;
  if (whole == count) return least == 1 ? Steps::of_one : Steps::equal;
  return whole <= 2 * count ? Steps::with_gaps : Steps::unequal;
}

template <class Part>
bool is_same_in_all(std::span<const Decimal> numbers, const Part& part) {
  return std::ranges::all_of(numbers, [&](const Decimal& number) { return part(number) == part(numbers.front()); });
}

enum class Reading { decimals, perhaps_decimals, others };

Reading reading_of(std::span<const Decimal> numbers) {
  const auto has_exponent = [](const Decimal& number) { return !number.exponent.empty(); };
  const auto has_fraction = [](const Decimal& number) { return !number.fraction.empty(); };
  if (std::ranges::any_of(numbers, has_exponent)) return Reading::decimals;
  if (std::ranges::none_of(numbers, has_fraction)) return Reading::others;
  const bool all_have = std::ranges::all_of(numbers, has_fraction);
  if (!all_have || std::ranges::any_of(numbers, &Decimal::is_minus_zero)) return Reading::decimals;
  const bool same_fraction = is_same_in_all(numbers, [](const Decimal& number) { return number.fraction; });
  const bool same_whole =
      is_same_in_all(numbers, [](const Decimal& number) { return std::pair(number.whole, number.minus); });
  const bool same_length = is_same_in_all(numbers, [](const Decimal& number) { return number.fraction.size(); });
  if (same_fraction) return Reading::others;
  if (same_length) return same_whole ? Reading::others : Reading::perhaps_decimals;
  std::vector<std::string_view> fractions;
  for (const Decimal& number : numbers) fractions.push_back(number.fraction);
  return judge_fractions(fractions) == FractionKind::fractions ? Reading::decimals : Reading::others;
}

}  // namespace

FractionKind judge_fractions(std::span<const std::string_view> digits) {
  std::size_t shortest = std::string_view::npos;
  std::size_t longest = 0;
  std::size_t longest_filled = 0;
  bool has_last_zero = false;
  for (const std::string_view text : digits) {
    shortest = std::min(shortest, text.size());
    longest = std::max(longest, text.size());
    if (text.size() > 1 && text.front() == '0') longest_filled = std::max(longest_filled, text.size());
    has_last_zero = has_last_zero || (text.size() > 1 && text.back() == '0');
  }
  if (shortest >= longest) return FractionKind::whole_numbers;
  // Numbers padded with zeros are never shorter than the padding.
  if (longest_filled > shortest) return FractionKind::fractions;
  const Steps steps = steps_of(digits);
  if (steps == Steps::of_one) return FractionKind::whole_numbers;
  return has_last_zero || steps != Steps::unequal ? FractionKind::unclear : FractionKind::fractions;
}

bool ends_in_exponent(std::string_view prefix) {
  const std::size_t size = prefix.size();
  return size > 2 && (prefix[size - 1] == '-' || prefix[size - 1] == '+') &&
         (prefix[size - 2] == 'e' || prefix[size - 2] == 'E') && is_digit(prefix[size - 3]);
}

bool ends_within_decimal(std::string_view prefix) {
  return ends_in_exponent(prefix) || (!prefix.empty() && is_decimal_point(prefix, prefix.size() - 1));
}

bool has_decimal_number(const files::FramePattern& pattern, std::string_view name) {
  const std::string& prefix = pattern.prefix();
  const std::string& suffix = pattern.suffix();
  if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) || !name.ends_with(suffix))
    return false;
  std::string word("_");  // a point at the start of a number follows a word
  word += name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
  const DecimalName split = split_decimals(word);
  return split.skeleton == std::string{'_', kNumberMark} &&
         !(split.numbers.front().fraction.empty() && split.numbers.front().exponent.empty());
}

std::optional<DecimalOrder> order_by_decimals(std::span<const std::string> names) {
  const std::vector<Decimal> numbers = differing_numbers(names);
  if (numbers.empty()) return std::nullopt;
  const Reading reading = reading_of(numbers);
  if (reading == Reading::others) return std::nullopt;
  const auto is_hyphen = [](const Decimal& number) { return number.minus && number.may_be_hyphen; };
  const bool with_sign = !std::ranges::all_of(numbers, is_hyphen);
  std::vector<double> values;
  for (const Decimal& number : numbers) {
    const auto value = number.value(with_sign);
    if (!value) return std::nullopt;
    values.push_back(*value);
  }
  DecimalOrder order{std::vector<std::size_t>(names.size()), reading == Reading::perhaps_decimals};
  std::iota(order.names.begin(), order.names.end(), std::size_t{0});
  std::ranges::sort(order.names, [&](std::size_t a, std::size_t b) {
    return values[a] != values[b] ? values[a] < values[b] : files::NaturalLess()(names[a], names[b]);
  });
  return order;
}

}  // namespace isoextract::batch

#include "batch/detail/sequences.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <unordered_map>
#include <utility>

#include "base/ascii.hpp"
#include "files/frame_pattern.hpp"

namespace isoextract::batch {
namespace {

// A group of digits in a name, and the minus sign before it, if any.
struct DigitGroup {
  std::string_view digits;
  std::size_t at = 0;  // position of the digits
  bool minus = false;
  bool may_be_hyphen = false;  // the minus follows a letter or digit, so it may be a hyphen

  [[nodiscard]] bool same(const DigitGroup& other) const { return digits == other.digits && minus == other.minus; }
  [[nodiscard]] std::int64_t number(bool with_sign) const {
    std::int64_t magnitude = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), magnitude);
    return with_sign && minus ? -magnitude : magnitude;
  }
};

struct SplitName {
  std::string skeleton;  // the name with a mark in place of each number and its sign
  std::vector<DigitGroup> groups;
};

SplitName split(std::string_view name) {
  SplitName result;
  for (std::size_t at = 0; at < name.size();) {
    const std::size_t first = std::min(name.find_first_of(kDigits, at), name.size());
    const std::size_t end = std::min(name.find_first_not_of(kDigits, first), name.size());
    result.skeleton += name.substr(at, first - at);
    if (end - first > files::kMaxFrameDigits) {
      result.skeleton += name.substr(first, end - first);
    } else if (end > first) {
      DigitGroup group{name.substr(first, end - first), first};
      group.minus = !result.skeleton.empty() && result.skeleton.back() == '-';
      if (group.minus) {
        result.skeleton.pop_back();
        group.may_be_hyphen = first > 1 && is_part_of_word(name[first - 2]);
      }
      result.skeleton += kNumberMark;
      result.groups.push_back(group);
    }
    at = end;
  }
  return result;
}

// File names that are equal except for digits.
struct NameGroup {
  std::vector<std::size_t> names;
  std::vector<std::vector<DigitGroup>> groups;  // of each name
};

// Returns the last group in which the names differ.
std::optional<std::size_t> frame_group(const NameGroup& alike) {
  for (std::size_t g = alike.groups.front().size(); g-- > 0;) {
    const auto differs = [&](const auto& groups) { return !groups[g].same(alike.groups.front()[g]); };
    if (std::ranges::any_of(alike.groups, differs)) return g;
  }
  return std::nullopt;
}

// Returns the numbers of a name except the frame number.
std::string other_numbers(std::span<const DigitGroup> groups, std::size_t frame) {
  std::string key;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (g == frame) continue;
    key += groups[g].minus ? "-" : "+";
    key += groups[g].digits;
  }
  return key;
}

// Returns the pattern of the names; `width` 0 matches any number of digits.
std::string pattern_of(std::string_view name, const DigitGroup& group, bool with_sign, int width) {
  const std::size_t first = group.at - (with_sign && group.minus ? 1 : 0);
  return files::FramePattern(std::string(name.substr(0, first)), width,
                             std::string(name.substr(group.at + group.digits.size())))
      .text();
}

Sequence sequence_of(std::span<const std::string> names, const NameGroup& alike, std::span<const std::size_t> chosen,
                     std::size_t frame) {
  const auto group = [&](std::size_t i) -> const DigitGroup& { return alike.groups[i][frame]; };
  const bool with_sign =
      !std::ranges::all_of(chosen, [&](std::size_t i) { return group(i).minus && group(i).may_be_hyphen; });
  std::size_t fewest = files::kMaxFrameDigits;
  for (const std::size_t i : chosen) fewest = std::min(fewest, group(i).digits.size());
  const int width = static_cast<int>(fewest);
  Sequence sequence;
  bool filled = false;
  bool as_width = true;
  for (const std::size_t i : chosen) {
    const std::int64_t number = group(i).number(with_sign);
    const std::string digits = files::frame_digits(number < 0 ? -number : number, width);
    as_width = as_width && digits == group(i).digits;
    filled = filled || (group(i).digits.size() > 1 && group(i).digits.front() == '0');
    sequence.members.push_back({alike.names[i], number});
  }
  sequence.pattern =
      pattern_of(names[alike.names[chosen.front()]], group(chosen.front()), with_sign, as_width && filled ? width : 0);
  return sequence;
}

Sequence lone(std::span<const std::string> names, std::size_t name) {
  return {{{name, trailing_number(names[name]).value_or(1)}}, names[name]};
}

}  // namespace

std::vector<Sequence> sequences_of(std::span<const std::string> names) {
  std::unordered_map<std::string, std::size_t> place;
  std::vector<NameGroup> all;
  for (std::size_t i = 0; i < names.size(); ++i) {
    SplitName name = split(names[i]);
    const auto [found, fresh] = place.try_emplace(std::move(name.skeleton), all.size());
    if (fresh) all.emplace_back();
    all[found->second].names.push_back(i);
    all[found->second].groups.push_back(std::move(name.groups));
  }
  std::vector<Sequence> sequences;
  for (const NameGroup& alike : all) {
    const auto frame = alike.names.size() > 1 ? frame_group(alike) : std::nullopt;
    if (!frame) {
      for (const std::size_t name : alike.names) sequences.push_back(lone(names, name));
      continue;
    }
    std::map<std::string, std::vector<std::size_t>> parted;
    for (std::size_t i = 0; i < alike.names.size(); ++i) {
      parted[other_numbers(alike.groups[i], *frame)].push_back(i);
    }
    for (const auto& [key, chosen] : parted) {
      sequences.push_back(chosen.size() > 1 ? sequence_of(names, alike, chosen, *frame)
                                            : lone(names, alike.names[chosen.front()]));
    }
  }
  std::ranges::sort(sequences, {}, [](const Sequence& sequence) { return sequence.members.front().name; });
  return sequences;
}

bool is_part_of_word(char c) { return is_digit(c) || is_letter(c) || static_cast<unsigned char>(c) >= 0x80; }

std::optional<std::int64_t> trailing_number(std::string_view path) {
  std::string_view name = path.substr(path.find_last_of('/') + 1);
  const std::size_t dot = name.find_last_of('.');
  const bool extension =
      dot != std::string_view::npos && name.find_first_not_of(kDigits, dot + 1) != std::string_view::npos;
  if (extension) name = name.substr(0, dot);
  const SplitName split_name = split(name);
  if (split_name.groups.empty()) return std::nullopt;
  const DigitGroup& last = split_name.groups.back();
  return last.number(!last.may_be_hyphen);
}

}  // namespace isoextract::batch

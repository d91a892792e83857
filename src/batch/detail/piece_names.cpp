#include "batch/detail/piece_names.hpp"

#include <algorithm>
#include <cctype>
#include <iterator>
#include <utility>

#include "convert/surface_edits.hpp"

namespace isoextract::batch {
namespace {

struct NameShape {
  std::string text;               // each run of digits and {piece} is one NUL, which no file name contains
  std::vector<std::string> runs;  // the digits of each run, up to the first {piece} in it
  std::vector<bool> numbered;     // whether the run contains {piece}
};

NameShape shape_of(std::string_view name) {
  NameShape shape;
  bool in_run = false;
  while (!name.empty()) {
    const bool number = name.starts_with(convert::kPiecePlaceholder);
    const bool digit = std::isdigit(static_cast<unsigned char>(name.front())) != 0;
    if (!number && !digit) {
      shape.text += name.front();
      in_run = false;
    } else if (!in_run) {
      shape.text += '\0';
      shape.runs.emplace_back();
      shape.numbered.push_back(false);
      in_run = true;
    }
    if (digit && !shape.numbered.back()) shape.runs.back() += name.front();
    if (number) shape.numbered.back() = true;
    name.remove_prefix(number ? convert::kPiecePlaceholder.size() : 1);
  }
  return shape;
}

// Returns the digits of a name that do not depend on body numbers. `numbered` marks the runs that contain {piece}.
std::string fixed_digits(const std::vector<std::string>& runs, const std::vector<bool>& numbered) {
  std::string digits;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!numbered[i]) digits += runs[i] + '\0';
  }
  const auto first = std::ranges::find(numbered, true) - numbered.begin();
  return digits + runs[static_cast<std::size_t>(first)];
}

bool one_begins_with_other(std::string_view a, std::string_view b) { return a.starts_with(b) || b.starts_with(a); }

}  // namespace

std::optional<std::size_t> PieceNames::add(std::string_view name, std::size_t owner) {
  const NameShape shape = shape_of(name);
  Group& group = groups_.try_emplace(shape.text, Group{shape.numbered, owner, {}}).first->second;
  if (group.numbered != shape.numbered) return group.owner;
  std::string digits = fixed_digits(shape.runs, shape.numbered);
  const auto after = group.owners.lower_bound(digits);
  if (after != group.owners.end() && one_begins_with_other(after->first, digits)) return after->second;
  if (after != group.owners.begin() && one_begins_with_other(std::prev(after)->first, digits)) {
    return std::prev(after)->second;
  }
  group.owners.emplace_hint(after, std::move(digits), owner);
  return std::nullopt;
}

std::optional<std::size_t> PieceNames::find_collision(std::string_view file) const {
  const NameShape shape = shape_of(file);
  const auto group = groups_.find(shape.text);
  if (group == groups_.end()) return std::nullopt;
  const std::string digits = fixed_digits(shape.runs, group->second.numbered);
  const auto after = group->second.owners.upper_bound(digits);
  if (after == group->second.owners.begin()) return std::nullopt;
  const auto& [known, owner] = *std::prev(after);
  return digits.starts_with(known) ? std::optional(owner) : std::nullopt;
}

}  // namespace isoextract::batch

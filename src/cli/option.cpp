#include "cli/option.hpp"

#include <algorithm>
#include <array>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/nearest_name.hpp"
#include "cli/values.hpp"

namespace isoextract::cli {
namespace {

std::vector<std::string> split(std::string_view text, char between) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = std::min(text.find(between, begin), text.size());
    parts.emplace_back(text.substr(begin, end - begin));
    if (end == text.size()) return parts;
    begin = end + 1;
  }
}

// Returns whether a part of a metavar stands for values, such as "N" or "cuda:N".
bool is_placeholder(const std::string& part) {
  return std::ranges::any_of(part, [](char c) { return c >= 'A' && c <= 'Z'; });
}

}  // namespace

const Option& OptionSet::at(std::ptrdiff_t distance) const {
  return *reinterpret_cast<const Option*>(reinterpret_cast<const std::byte*>(this) + distance);
}

void OptionSet::add(const Option& option) {
  const auto is_in = [&](OptionGroup group) {
    return [this, group](std::ptrdiff_t other) { return at(other).row().group == group; };
  };
  const auto last = std::find_if(options_.rbegin(), options_.rend(), is_in(option.row().group));
  const auto place = last != options_.rend() ? last.base() : std::ranges::find_if(options_, is_in(OptionGroup::run));
  options_.insert(place, reinterpret_cast<const std::byte*>(&option) - reinterpret_cast<const std::byte*>(this));
  if (whole_ != nullptr) whole_->add(option);
}

std::vector<const Option*> OptionSet::options() const {
  std::vector<const Option*> all;
  for (const std::ptrdiff_t distance : options_) all.push_back(&at(distance));
  return all;
}

std::vector<Option*> OptionSet::options() {
  std::vector<Option*> all;
  for (const std::ptrdiff_t distance : options_) all.push_back(const_cast<Option*>(&at(distance)));
  return all;
}

std::vector<const Option*> OptionSet::in_group(OptionGroup group) const {
  std::vector<const Option*> found = options();
  std::erase_if(found, [&](const Option* option) { return option->row().group != group; });
  return found;
}

const Option* OptionSet::find(std::string_view name) const {
  if (!name.starts_with('-')) return nullptr;
  for (const Option* option : options()) {
    if (std::ranges::find(option->row().names, name) != option->row().names.end()) return option;
  }
  return nullptr;
}

const Option* OptionSet::operand() const {
  const auto all = options();
  const auto found = std::ranges::find_if(all, &Option::is_positional);
  return found == all.end() ? nullptr : *found;
}

bool OptionSet::any_set() const { return std::ranges::any_of(options(), &Option::is_set); }

std::vector<const Option*> OptionSet::set_about(About what) const {
  std::vector<const Option*> found = options();
  std::erase_if(found, [&](const Option* option) { return !option->is_about(what) || !option->is_set(); });
  return found;
}

Result<void> OptionSet::refuse(About what, std::string_view why, std::string_view hint) const {
  const auto given = set_about(what);
  if (given.empty()) return {};
  const std::string& name = given.front()->name();
  return fail(ErrorCode::usage, fmt::format(fmt::runtime(why), name), fmt::format(fmt::runtime(hint), name));
}

Option::Option(const Place& place, OptionRow row) {
  row.everyday = place.everyday;
  row_ = std::make_shared<const OptionRow>(std::move(row));
  if (place.set != nullptr) place.set->add(*this);
}

std::string Option::spelling() const {
  if (is_positional()) return choices().empty() ? row_->metavar : name();
  const std::string names = fmt::format("{}", fmt::join(row_->names, ", "));
  if (!takes_value()) return names;
  return fmt::format(fmt::runtime(row_->left_out ? "{} [{}]" : "{} {}"), names, row_->metavar);
}

std::vector<std::string> Option::choices() const {
  if (row_->metavar.find('|') == std::string::npos) return {};
  std::vector<std::string> words = split(row_->metavar, '|');
  std::erase_if(words, is_placeholder);
  return words;
}

bool Option::takes_file() const {
  constexpr std::array<std::string_view, 5> kFiles{"FILE", "PATH", "INPUT", "INPUT...", "MESH"};
  return std::ranges::any_of(split(row_->metavar, '|'),
                             [&](const std::string& part) { return std::ranges::find(kFiles, part) != kFiles.end(); });
}

tl::unexpected<Error> Option::refuse(Error why) const {
  why.message = fmt::format("{}: {}", name(), why.message);
  return tl::unexpected(std::move(why));
}

std::vector<std::string> split_names(std::string_view names) { return split(names, ','); }

std::string metavar_of(const std::vector<std::string>& words) { return fmt::format("{}", fmt::join(words, "|")); }

Result<std::size_t> index_among(const std::vector<std::string>& words, std::string_view text) {
  const auto found = std::ranges::find(words, text);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  const std::string near = nearest_name(text, words);
  return fail(ErrorCode::usage, fmt::format("expected one of {}, found '{}'", fmt::join(words, ", "), text),
              near.empty() ? "" : fmt::format("did you mean '{}'?", near));
}

Result<void> refuse_both(const Option& a, const Option& b, std::string_view why, Hint hint) {
  if (!a.is_set() || !b.is_set()) return {};
  return fail(ErrorCode::usage,
              fmt::format("{} and {} exclude each other{}{}", a.name(), b.name(), why.empty() ? "" : ": ", why),
              std::move(hint));
}

}  // namespace isoextract::cli

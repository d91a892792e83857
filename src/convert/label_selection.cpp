#include "convert/label_selection.hpp"

#include <algorithm>
#include <charconv>
#include <limits>
#include <system_error>

namespace isoextract::convert {
namespace {

// Parses a number at the start of `text` and removes it.
std::optional<std::int64_t> take_number(std::string_view& text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

// Returns whether the whole text matches, in time proportional to the product of the lengths.
bool matches(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t after_star = std::string_view::npos;
  std::size_t star_text = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      after_star = ++p;
      star_text = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
      const bool is_any = pattern[p++] == '?';
      ++t;
      while (is_any && t < text.size() && (static_cast<unsigned char>(text[t]) & 0xC0U) == 0x80U) ++t;
    } else if (after_star != std::string_view::npos) {
      p = after_star;
      t = ++star_text;
    } else {
      return false;
    }
  }
  return std::ranges::all_of(pattern.substr(p), [](char c) { return c == '*'; });
}

constexpr std::string_view kWildcards = "*?";

}  // namespace

std::optional<LabelSelection> LabelSelection::parse(std::string_view text) {
  LabelSelection selection;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    std::string_view word = text.substr(begin, end - begin);
    begin = end + 1;
    Term term;
    term.text = word;
    term.excludes = word.starts_with('!');
    if (term.excludes) word.remove_prefix(1);
    if (word.empty()) return std::nullopt;
    std::string_view rest = word;
    const auto first = take_number(rest);
    if (word == "all") {
      term.first = std::numeric_limits<std::int64_t>::min();
      term.last = std::numeric_limits<std::int64_t>::max();
    } else if (first && rest.empty()) {
      term.first = term.last = *first;
    } else {
      const bool has_dash = first && rest.starts_with('-');
      if (has_dash) rest.remove_prefix(1);
      const auto last = has_dash ? take_number(rest) : std::nullopt;
      if (last && rest.empty()) {
        if (*last < *first) return std::nullopt;
        term.first = *first;
        term.last = *last;
      } else {
        term.is_name = true;
      }
    }
    selection.only_excludes_ = selection.only_excludes_ && term.excludes;
    selection.terms_.push_back(std::move(term));
  }
  return selection;
}

bool LabelSelection::contains(std::int64_t label, std::string_view name) {
  bool chosen = only_excludes_;
  bool excluded = false;
  for (Term& term : terms_) {
    const std::string_view pattern = std::string_view(term.text).substr(term.excludes ? 1 : 0);
    const bool is_it =
        term.is_name ? matches(pattern, name) && !name.empty() : term.first <= label && label <= term.last;
    if (!is_it) continue;
    term.matched = true;
    (term.excludes ? excluded : chosen) = true;
  }
  return chosen && !excluded;
}

bool LabelSelection::is_one_name() const {
  const Term& term = terms_.front();
  return terms_.size() == 1 && !term.excludes && term.is_name &&
         term.text.find_first_of(kWildcards) == std::string::npos;
}

std::vector<LabelSelection::UnmatchedTerm> LabelSelection::unmatched() const {
  std::vector<UnmatchedTerm> found;
  for (const Term& term : terms_) {
    if (term.excludes || term.matched) continue;
    const bool is_one =
        term.is_name ? term.text.find_first_of(kWildcards) == std::string::npos : term.first == term.last;
    found.push_back({term.text, is_one});
  }
  return found;
}

}  // namespace isoextract::convert

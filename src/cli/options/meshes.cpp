#include "cli/options/meshes.hpp"
#include "base/nearest_name.hpp"

#include <algorithm>
#include <array>

#include <fmt/ranges.h>

namespace isoextract::cli {
namespace {

using check::Requirement;

constexpr std::string_view kPrintable = "printable";
constexpr std::array kOfPrintable{Requirement::closed,
                                  Requirement::manifold,
                                  Requirement::oriented,
                                  Requirement::outward,
                                  Requirement::no_self_intersections,
                                  Requirement::no_zero_area,
                                  Requirement::no_duplicates};

std::vector<std::string> requirement_words() {
  std::vector<std::string> words;
  for (const Word<Requirement>& entry : words_of(Requirement{})) words.emplace_back(entry.word);
  return words;
}

}  // namespace

std::string requirement_list() {
  std::vector<std::string_view> words;
  for (const Requirement one : kOfPrintable) words.push_back(word_of(one));
  return fmt::format("{}; or {}, which is {}", fmt::join(requirement_words(), ", "), kPrintable,
                     fmt::join(words, ", "));
}

Result<std::vector<Requirement>> parse_requirements(std::string_view text) {
  std::vector<Requirement> required;
  const auto add = [&](Requirement one) {
    if (std::ranges::find(required, one) == required.end()) required.push_back(one);
  };
  std::vector<std::string> words = requirement_words();
  words.emplace_back(kPrintable);
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string_view word = text.substr(at, end - at);
    at = end + 1;
    if (const auto one = value_of<Requirement>(word)) {
      add(*one);
    } else if (word == kPrintable) {
      for (const Requirement part : kOfPrintable) add(part);
    } else {
      const std::string near = nearest_name(word, words);
      return fail(ErrorCode::usage,
                  fmt::format("expected a comma-separated list of {}, found '{}'", fmt::join(words, ", "), word),
                  near.empty() ? "" : fmt::format("did you mean '{}'?", near));
    }
  }
  return required;
}

CompareFlags::CompareFlags() = default;
CheckFlags::CheckFlags() = default;

}  // namespace isoextract::cli

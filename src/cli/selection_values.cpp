#include <string>

#include <fmt/format.h>

#include "cli/values.hpp"
#include "points/selection_expression.hpp"

namespace isoextract::cli {

Result<std::string> parse_selection(std::string_view text) {
  TRY(points::SelectionExpression::parse(text));
  return std::string(text);
}

Result<std::string> parse_types(std::string_view text) { return parse_selection(fmt::format("type in {{{}}}", text)); }

Result<std::string> parse_species(std::string_view text) {
  std::string words;
  while (true) {
    const std::size_t comma = text.find(',');
    const std::string_view word = text.substr(0, comma);
    if (word.empty()) {
      return fail(ErrorCode::usage, fmt::format("expected names of species such as O,H, found '{}'", text));
    }
    words += (words.empty() ? "" : ", ") + points::word_in_selection(word);
    if (comma == std::string_view::npos) break;
    text.remove_prefix(comma + 1);
  }
  return parse_selection(fmt::format("species in {{{}}}", words));
}

}  // namespace isoextract::cli

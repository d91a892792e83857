// Holds help as data and lays it out as plain text; help pages and man page use the same blocks. Also formats the lines
// of reports.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isoextract::cli {

// A term and its explanation: an option, a format, an exit code.
struct HelpRow {
  std::string term;
  std::string text;
};

// A paragraph, then a list; either may be empty.
struct HelpBlock {
  std::string paragraph;
  std::vector<HelpRow> rows;
};

// The longest HelpRow::text, in bytes, that plain_text() puts on one line.
inline constexpr std::size_t kSummaryWidth = 55;

// Returns lines of at most `width` bytes, broken at spaces; several spaces become one. A longer word gets its own line.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t width);

// Returns the first sentence: "Sets the size." of "Sets the size. The default is 3."
[[nodiscard]] std::string first_sentence(std::string_view text);

// Collects the lines of a report for stdout. add() appends "  name          text", plain() appends a line as it is.
class NamedLines {
 public:
  void add(std::string_view name, std::string_view text);
  void plain(std::string_view text);
  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

// Formats a block for a terminal of 80 columns; ends with a newline unless the block is empty. Breaks a term that is
// longer than a line, such as --format with its choices, after a '|'.
[[nodiscard]] std::string plain_text(const HelpBlock& block);

}  // namespace isoextract::cli

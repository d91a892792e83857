// Help as data, and its layout as plain text: the help pages and the man page are made from the same blocks. And the
// lines of reports.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace isoextract::cli {

// A term and what is said of it: an option, a format, an exit code.
struct HelpRow {
  std::string term;
  std::string text;
};

// A paragraph, then a list; either may be empty.
struct HelpBlock {
  std::string paragraph;
  std::vector<HelpRow> rows;
};

// Lines of at most `width` characters, broken at spaces. A word longer than that has a line of its own.
[[nodiscard]] std::vector<std::string> wrapped(std::string_view text, std::size_t width);

// Collects "  name          text" lines under a heading, as reports on stdout have them.
class NamedLines {
 public:
  void add(std::string_view name, std::string_view text);
  void plain(std::string_view text);
  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  std::string out_;
};

// Paragraph and list for a terminal of 80 columns; ends with a newline unless the block is empty.
[[nodiscard]] std::string plain_text(const HelpBlock& block);

}  // namespace isoextract::cli

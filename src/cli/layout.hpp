// Help as data, and its layout as plain text: the help pages and the man page are made from the same blocks.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isoextract {

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

// Paragraph and list for a terminal of 80 columns; ends with a newline unless the block is empty.
[[nodiscard]] std::string plain_text(const HelpBlock& block);

}  // namespace isoextract

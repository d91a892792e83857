#include "cli/layout.hpp"

#include <fmt/format.h>

namespace isoextract::cli {
namespace {

constexpr std::size_t kWidth = 80;
constexpr std::size_t kTermColumn = 2;
constexpr std::size_t kTextColumn = kWidth - kSummaryWidth;

}  // namespace

std::string first_sentence(std::string_view text) {
  const std::size_t stop = text.find(". ");
  return std::string(stop == std::string_view::npos ? text : text.substr(0, stop + 1));
}

std::vector<std::string> wrapped(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  std::string line;
  while (!text.empty()) {
    const std::size_t start = text.find_first_not_of(' ');
    if (start == std::string_view::npos) break;
    text.remove_prefix(start);
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(end);
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      lines.push_back(std::move(line));
      line.clear();
    }
    if (!line.empty()) line += ' ';
    line += word;
  }
  if (!line.empty()) lines.push_back(std::move(line));
  return lines;
}

std::string plain_text(const HelpBlock& block) {
  std::string out;
  for (const std::string& line : wrapped(block.paragraph, kWidth)) out += line + "\n";
  if (!block.paragraph.empty() && !block.rows.empty()) out += "\n";
  for (const HelpRow& row : block.rows) {
    std::string line = std::string(kTermColumn, ' ') + row.term;
    while (line.size() > kWidth) {
      const std::size_t bar = line.rfind('|', kWidth - 1);
      if (bar == std::string::npos) break;
      out += line.substr(0, bar + 1) + "\n";
      line = std::string(kTextColumn, ' ') + line.substr(bar + 1);
    }
    for (const std::string& text : wrapped(row.text, kWidth - kTextColumn)) {
      if (line.size() + 1 >= kTextColumn && !line.empty()) {
        out += line + "\n";
        line.clear();
      }
      line.resize(kTextColumn, ' ');
      out += line + text + "\n";
      line.clear();
    }
    if (!line.empty()) out += line + "\n";
  }
  return out;
}

void NamedLines::add(std::string_view name, std::string_view text) { out_ += fmt::format("  {:<13} {}\n", name, text); }
void NamedLines::plain(std::string_view text) { out_ += fmt::format("{}\n", text); }

}  // namespace isoextract::cli

// Generates the man page in mdoc(7) macros.
#include <cctype>
#include <string_view>

#include <fmt/format.h>

#include "base/version.hpp"
#include "cli/command.hpp"
#include "cli/generate_docs.hpp"
#include "cli/help_topics.hpp"

namespace isoextract::cli {
namespace {

constexpr std::string_view kDate = "November 26, 2026";  // date of the last change of the texts
constexpr std::size_t kLineWidth = 72;                   // before escapes

// Escapes text so that roff prints it unchanged.
std::string roff_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '^') {
      out += "\\(ha";
    } else if (c == '~') {
      out += "\\(ti";
    } else {
      out += c;
    }
  }
  return out;
}

// Formats a paragraph with a new line after each sentence, as roff requires, and no line that looks like a macro.
std::string paragraph(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t stop = text.find(". ");
    const std::string_view sentence = text.substr(0, stop == std::string_view::npos ? text.size() : stop + 1);
    text.remove_prefix(std::min(text.size(), sentence.size() + 1));
    for (const std::string& line : wrapped(sentence, kLineWidth)) {
      out += fmt::format("{}{}\n", line.front() == '.' || line.front() == '\'' ? "\\&" : "", roff_text(line));
    }
  }
  return out;
}

// Quotes the terms, because ".It" would interpret their words as macros.
std::string tagged_list(const std::vector<HelpRow>& rows) {
  std::string out = ".Bl -tag -width Ds\n";
  for (const HelpRow& row : rows) {
    out += fmt::format(".It Sy \"{}\"\n{}", roff_text(row.term), paragraph(row.text));
  }
  return out + ".El\n";
}

std::string block_text(const HelpBlock& block) {
  std::string out = paragraph(block.paragraph);
  if (!block.rows.empty()) out += tagged_list(block.rows);
  return out;
}

std::string upper(std::string_view text) {
  std::string out;
  for (const char c : text) out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return out;
}

std::string synopsis_section(const Command& program) {
  std::string out = ".Sh SYNOPSIS\n";
  for (const Command* command : all_commands(program)) {
    if (!command->inner().empty()) continue;
    const std::string line = command->synopsis();
    out += fmt::format(".Nm\n{}\n", roff_text(line.substr(line.find(' ') + 1)));
  }
  return out;
}

std::string commands_section(const Command& program) {
  std::vector<HelpRow> rows;
  for (const Command* command : all_commands(program)) rows.push_back({command->full_name(), command->summary()});
  return ".Sh COMMANDS\n" + tagged_list(rows);
}

std::string options_section(const Command& command) {
  std::string out = fmt::format(".Sh OPTIONS OF {}\n", upper(command.full_name()));
  for (const Word<OptionGroup>& group : words_of(OptionGroup{})) {
    const HelpBlock block = group_block(command, group.value);
    if (!block.rows.empty()) out += fmt::format(".Ss {}\n{}", group.word, tagged_list(block.rows));
  }
  return out;
}

std::string examples_section() {
  std::string out = ".Sh EXAMPLES\n";
  for (const Example& example : examples()) {
    out += fmt::format("{}.Pp\n.Dl {}\n.Pp\n", paragraph(example.text), roff_text(example.command));
  }
  return out.substr(0, out.size() - std::string_view(".Pp\n").size());
}

std::string exit_status_section(const HelpTopic& topic) {
  return ".Sh EXIT STATUS\n" + block_text(topic.blocks.front());
}

}  // namespace

std::string man_page(const Command& program) {
  std::string out =
      "."
      R"(\" Made by 'isoextract generate man'; do not edit.)"
      "\n";
  out += fmt::format(".Dd {}\n.Dt ISOEXTRACT 1\n.Os\n", kDate);
  out += ".Sh NAME\n.Nm isoextract\n.Nd extract isosurfaces from volumes and write them as meshes\n";
  out += synopsis_section(program);
  out += ".Sh DESCRIPTION\n";
  out += paragraph(
      "isoextract reads a volume, a scalar field of samples on a grid, and writes the surface where the field has a "
      "chosen value as a triangle mesh. Inside is where the value is above the iso value, or below it for level sets. "
      "Meshes are closed wherever the surface does not leave the data, and the same input and options give the same "
      "bytes whatever the number of threads.");
  out += commands_section(program);
  for (const Command* command : all_commands(program)) out += options_section(*command);
  out += ".Sh OPTIONS WITHOUT A COMMAND\n" + tagged_list(group_block(program, OptionGroup::run).rows);
  std::string exit_status;
  for (const HelpTopic& topic : help_topics()) {
    if (topic.name == "exit-codes") {
      exit_status = exit_status_section(topic);
      continue;
    }
    out += fmt::format(".Sh {}\n", upper(topic.title));
    for (std::size_t i = 0; i < topic.blocks.size(); ++i) {
      if (i > 0) out += ".Pp\n";
      out += block_text(topic.blocks[i]);
    }
  }
  return out + exit_status + examples_section();
}

}  // namespace isoextract::cli

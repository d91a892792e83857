// Help pages: subjects, examples, and the composition of all pages.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/command.hpp"
#include "cli/layout.hpp"

namespace isoextract::cli {

// A subject of the help, which is also a section of the man page.
struct HelpTopic {
  std::string_view name;  // as in 'isoextract help NAME'
  std::string_view title;
  std::string_view summary;  // one line for the overview
  std::vector<HelpBlock> blocks;
};
[[nodiscard]] std::vector<HelpTopic> help_topics();

inline constexpr std::string_view kExamplesTopic = "examples";

struct Example {
  std::string_view command;
  std::string_view brief;  // a few words for the overview; empty: the overview omits the example
  std::string_view text;   // a sentence
};
[[nodiscard]] std::span<const Example> examples();

// Returns the rows of a command's options in a group.
[[nodiscard]] HelpBlock group_block(const Command& command, OptionGroup group);

// Returns the words that 'isoextract help' takes: commands, option groups of the default command in lower case,
// subjects, and "examples".
[[nodiscard]] std::vector<std::string> help_names(const Command& program);

// Returns the first page: usage, everyday options, a few examples, and the names of other pages. Fits 40 lines.
[[nodiscard]] std::string help_overview(const Command& program);
// Returns summary, usage, sub-commands and options. Adds the examples for the default command with HelpDetail::all.
[[nodiscard]] std::string help_of_command(const Command& command, HelpDetail detail);
// Returns the page of a command, a group, a subject or the examples. `name` is one of help_names(); returns an empty
// text for other names.
[[nodiscard]] std::string help_of(const Command& program, std::string_view name);
// Returns the text that a call without arguments prints: the usage of each command and an example.
[[nodiscard]] std::string short_usage(const Command& program);

}  // namespace isoextract::cli

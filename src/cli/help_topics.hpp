// What the help says beyond the options: subjects, examples, and how all of it is put together.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/layout.hpp"

namespace CLI {
class App;
}

namespace isoextract::cli {

// A subject of its own, in the help and as a section of the man page.
struct HelpTopic {
  std::string_view name;  // as in 'isoextract help NAME'
  std::string_view title;
  std::string_view summary;  // one line for the overview
  std::vector<HelpBlock> blocks;
};
[[nodiscard]] std::vector<HelpTopic> help_topics();

struct Example {
  std::string_view command;
  std::string_view text;  // what it does
};
[[nodiscard]] std::span<const Example> examples();

// The groups that options are in, in the order of the help.
[[nodiscard]] std::span<const std::string_view> option_groups();

// The rows of a command's options in a group.
[[nodiscard]] HelpBlock group_block(const CLI::App& command, std::string_view group);

// Every word that 'isoextract help' takes: commands, groups, subjects.
[[nodiscard]] std::vector<std::string> help_names();

[[nodiscard]] std::string help_overview(const CLI::App& app);
[[nodiscard]] std::string help_of_command(const CLI::App& command);
// `name` is one of help_names().
[[nodiscard]] std::string help_of(const CLI::App& app, std::string_view name);
// A few lines for someone who gave no argument at all.
[[nodiscard]] std::string short_usage(const CLI::App& app);

}  // namespace isoextract::cli

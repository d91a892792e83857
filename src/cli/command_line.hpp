// Turns the words of the command line into a command and its options, or into an error that names the wrong word.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"

namespace isoextract::cli {

// Returns the command that the first word names, or the default command. `arguments` do not include the program's name.
[[nodiscard]] Command& find_command(const Command& program, const std::vector<std::string>& arguments);
// Returns the sub-command that the first two arguments name, such as `simulate water`; otherwise the result of
// find_command().
[[nodiscard]] Command& find_subcommand(const Command& program, const std::vector<std::string>& arguments);
// Returns the arguments after Command::path() of `command`; all arguments if they do not begin with this path.
[[nodiscard]] std::vector<std::string> arguments_after_command(const Command& command,
                                                               const std::vector<std::string>& arguments);

struct Parsed {
  Command* command = nullptr;      // the program itself if the first word is one of its own options
  std::optional<HelpDetail> help;  // show it instead of running the command; never set if `command` is the program
};

// Parses `arguments`, which do not include the program's name and are not empty. Fails with ErrorCode::usage.
[[nodiscard]] Result<Parsed> parse_command_line(Command& program, const std::vector<std::string>& arguments);

// Parses the words after a command's name. The command's options must have their defaults. Fails with ErrorCode::usage.
// If the words ask for help, takes no values and does not report unknown options.
[[nodiscard]] Result<void> parse_words(Command& command, std::vector<std::string> words);
// Reads as many as possible of the words that parse_words() refused. The command's options must have their defaults.
// Skips "--", options that lack a value, and values that an option refuses. Words that belong to no option become
// operands; so do the values of "--unknown=FILE" and "--flag=FILE".
void read_words_leniently(Command& command, const std::vector<std::string>& words);

}  // namespace isoextract::cli

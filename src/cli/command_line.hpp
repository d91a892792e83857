// Turns the words of the command line into a command and its options, or into an error that names the wrong word.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"

namespace isoextract::cli {

// Returns the command that the first word names, or the default command. `arguments` lack the program's name.
[[nodiscard]] Command& find_command(const Command& program, const std::vector<std::string>& arguments);
// Returns the sub-command that the arguments name, such as `simulate water`; the result of find_command() if they name
// none.
[[nodiscard]] Command& find_subcommand(const Command& program, const std::vector<std::string>& arguments);
[[nodiscard]] std::vector<std::string> arguments_after_command(const Command& command,
                                                               const std::vector<std::string>& arguments);

struct Parsed {
  Command* command = nullptr;      // the program itself if its own options are given
  std::optional<HelpDetail> help;  // show it instead of running the command
};

// Parses `arguments`, which lack the program's name and are not empty.
[[nodiscard]] Result<Parsed> parse_command_line(Command& program, const std::vector<std::string>& arguments);

// Parses the words after a command's name. The command's options must have their defaults.
[[nodiscard]] Result<void> parse_words(Command& command, std::vector<std::string> words);
// Reads as many as possible of the words that parse_words() refused. Skips values that their options refuse. All other
// words become operands.
void read_words_leniently(Command& command, const std::vector<std::string>& words);

}  // namespace isoextract::cli

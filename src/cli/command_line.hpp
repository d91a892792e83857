// From the words of the command line to a command and its options, or to a message that says which word is wrong.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"

namespace isoextract::cli {

// The command that the first of the words, without the program's name, is about: the default one where it names none.
[[nodiscard]] Command& command_of(const Command& program, const std::vector<std::string>& arguments);
// Returns the command within that one where it has several, such as `simulate water`, and that one where they name
// none.
[[nodiscard]] Command& innermost_command_of(const Command& program, const std::vector<std::string>& arguments);
[[nodiscard]] std::vector<std::string> words_after_name(const Command& command,
                                                        const std::vector<std::string>& arguments);

struct Parsed {
  Command* command = nullptr;  // the program, where its own options are asked for
  bool asks_for_help = false;  // and the command is not to run
};

// `arguments` are without the program's name and not empty.
[[nodiscard]] Result<Parsed> parse_command_line(Command& program, const std::vector<std::string>& arguments);

// The words after a command's name. Its options are as they were declared.
[[nodiscard]] Result<void> parse_words(Command& command, std::vector<std::string> words);
// Reads what there is to read in words that make no options. Values that their options refuse are left out, and what is
// no option is an operand.
void read_refused_words(Command& command, const std::vector<std::string>& words);

}  // namespace isoextract::cli

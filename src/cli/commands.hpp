// The commands of the program.
#pragma once

#include <memory>

#include "cli/command.hpp"

namespace isoextract::cli {

// Returns the program with all its commands, in the order of the help; the first is the default command. The program's
// options (--help, --help-all, --version) work without a command.
[[nodiscard]] std::unique_ptr<Command> make_program();

}  // namespace isoextract::cli

// The commands of the program.
#pragma once

#include <memory>

#include "cli/command.hpp"

namespace isoextract::cli {

// The program with all its commands, in the order in which help shows them; the first is the default one. Its own
// options are those that are given without a command.
[[nodiscard]] std::unique_ptr<Command> make_program();

}  // namespace isoextract::cli

// Generates the man page and the shell completions from the declarations of the commands.
#pragma once

#include <string>

#include "cli/command.hpp"

namespace isoextract::cli {

// Returns the man page in mdoc format.
[[nodiscard]] std::string man_page(const Command& program);
[[nodiscard]] std::string bash_completion(const Command& program);
[[nodiscard]] std::string zsh_completion(const Command& program);
[[nodiscard]] std::string fish_completion(const Command& program);

}  // namespace isoextract::cli

// Turns hints into text. Only this file knows which options a Setting stands for.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"

namespace isoextract::cli {

// Returns, for example, "give a larger --memory-limit SIZE if the machine has the memory". Leaves out options that the
// command lacks, and steps of which no option is left; empty if no step is left.
[[nodiscard]] std::string words_of(const Hint& hint);

// Sets the options that words_of() may name: those of the running command, with their dashes ("--grid"). Without a call
// it may name all. Not thread-safe: call before the work.
void set_options_of_hints(std::vector<std::string> names);

}  // namespace isoextract::cli

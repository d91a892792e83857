// Turns hints into text. Only remedies.cpp knows which options a Setting stands for.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"

namespace isoextract::cli {

// Returns, for example, "give a larger --memory-limit SIZE if the machine has the memory". Leaves out the options that
// the running command does not have, and steps without a remaining option. Returns an empty text if no step remains.
[[nodiscard]] std::string hint_text(const Hint& hint);

// Sets the options that hint_text() may name: those of the running command, with their dashes ("--grid"). Before the
// first call, hint_text() may name all options. Not thread-safe: call it before the work starts.
void set_options_of_hints(std::vector<std::string> names);

}  // namespace isoextract::cli

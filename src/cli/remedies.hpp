// What helps, in the program's own words: the one place that knows which option stands behind a Remedy.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"

namespace isoextract::cli {

// "raise it with --memory-limit SIZE if the machine has the memory"; empty where nothing is known to help.
// Parts of a hint that name options which the command has not are left out.
[[nodiscard]] std::string words_of(const Hint& hint);

// Names, with their dashes, of the options of the command that runs, for words_of(); all options until it is called.
void set_options_of_hints(std::vector<std::string> names);

}  // namespace isoextract::cli

// What helps, in the program's own words: the one place that knows which option stands behind a Remedy.
#pragma once

#include <string>

#include "base/error.hpp"

namespace isoextract::cli {

// "raise it with --memory-limit SIZE if the machine has the memory"; empty where nothing is known to help.
[[nodiscard]] std::string words_of(const Hint& hint);

}  // namespace isoextract::cli

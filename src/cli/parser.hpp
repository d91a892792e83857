// Assigns words of the command line to options. Only parser.cpp uses CLI11.
#pragma once

#include <string>
#include <vector>

#include "cli/option.hpp"

namespace isoextract::cli {

struct ReadWords {
  std::vector<std::string> rest;  // words that no option takes: further operands and unknown options
  std::string problem;            // why reading ended early; empty if it did not
};

// Appends the texts in `words` to the options they belong to.
[[nodiscard]] ReadWords read_words(OptionSet& options, const std::vector<std::string>& words);

}  // namespace isoextract::cli

// Assigns words of the command line to options. Only parser.cpp uses CLI11.
#pragma once

#include <string>
#include <vector>

#include "cli/option.hpp"

namespace isoextract::cli {

struct ReadWords {
  std::vector<std::string> rest;  // words that no option takes: further operands and unknown options
  std::string problem;            // message of CLI11 if it rejected the words, else empty
};

// Appends each value in `words` to its option as unparsed text (Option::add_text).
[[nodiscard]] ReadWords read_words(OptionSet& options, const std::vector<std::string>& words);

}  // namespace isoextract::cli

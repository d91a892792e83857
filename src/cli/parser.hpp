// Words as texts of options: the one place that knows CLI11.
#pragma once

#include <string>
#include <vector>

#include "cli/option.hpp"

namespace isoextract::cli {

struct ReadWords {
  std::vector<std::string> rest;  // which no option takes: further operands, and options that are not declared
  std::string problem;            // what ended the reading early; empty where nothing did
};

// Adds to the texts of each option what `words` give for it.
[[nodiscard]] ReadWords read_words(OptionSet& options, const std::vector<std::string>& words);

}  // namespace isoextract::cli

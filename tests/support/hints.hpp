// Reads hints in tests of rooms below cli, which words them.
#pragma once

#include <algorithm>
#include <string>

#include "base/error.hpp"

namespace isoextract::test {

inline bool has_step(const Hint& hint, Remedy remedy, Setting setting) {
  return std::ranges::any_of(hint.steps,
                             [&](const Step& step) { return step.remedy == remedy && step.setting == setting; });
}

// Returns the texts of all steps, a line each.
inline std::string text_of(const Hint& hint) {
  std::string text;
  for (const Step& step : hint.steps) text += (text.empty() || step.text.empty() ? "" : "\n") + step.text;
  return text;
}

}  // namespace isoextract::test

// Finds the name that a misspelled word most likely means, for "did you mean".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isoextract {

// Returns the candidate that `text` most likely means: one that starts with `text` (3 bytes or more), or whose edit
// distance is at most a third of its bytes, or 1. Returns "" if there is none, or if `text` has fewer than 2 bytes.
[[nodiscard]] std::string nearest_name(std::string_view text, const std::vector<std::string>& candidates);

// Returns " (did you mean 'NAME'?)" with that candidate, printable, or an empty text.
[[nodiscard]] std::string did_you_mean(std::string_view text, const std::vector<std::string>& candidates);

}  // namespace isoextract

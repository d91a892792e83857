// Finds the name that a misspelled word most likely means, for "did you mean".
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace isoextract {

// Returns the candidate that `text` most likely means: the first that starts with `text` (3 bytes or more), else the
// one with the least edit distance. Returns "" if that distance exceeds both 1 and a third of the length of `text` in
// bytes, or if `text` has fewer than 2 bytes.
[[nodiscard]] std::string nearest_name(std::string_view text, const std::vector<std::string>& candidates);

// Returns " (did you mean 'NAME'?)" with nearest_name(), made printable, or an empty text if there is none.
[[nodiscard]] std::string did_you_mean(std::string_view text, const std::vector<std::string>& candidates);

}  // namespace isoextract

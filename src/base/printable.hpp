// Escapes text from files and paths for messages: it may contain characters that control the terminal.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace isoextract {

// Returns valid UTF-8 as it is, except that it escapes control characters (\x1b), line ends and separators (\n,
// \u2028), and embeddings, overrides and isolates of the writing direction (\u202e). Also escapes bytes that are not
// UTF-8 (\xe9). Leaves backslashes, so escaping the result again changes nothing. Reads at most `max_bytes` of `text`,
// in whole characters; "..." stands for the rest.
[[nodiscard]] std::string printable(std::string_view text, std::size_t max_bytes = std::string_view::npos);
[[nodiscard]] std::string printable(std::span<const std::byte> bytes, std::size_t max_bytes);

}  // namespace isoextract

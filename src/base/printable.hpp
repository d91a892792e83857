// Text that came from a file or a path, for messages: such text may hold anything, and a terminal obeys some of it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace isoextract {

// Valid UTF-8 stays as it is. Escaped are control characters, line ends among them (\n, \x1b), what turns the direction
// of writing round (\u202e), and bytes that are no UTF-8 (\xe9). What is printable already stays as it is, so that
// doing it twice does no harm. Of a longer text "..." stands for what comes after `max_bytes` of it, whole characters
// only.
[[nodiscard]] std::string printable(std::string_view text, std::size_t max_bytes = std::string_view::npos);
[[nodiscard]] std::string printable(std::span<const std::byte> bytes, std::size_t max_bytes);

}  // namespace isoextract

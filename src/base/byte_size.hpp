// Byte sizes as text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract {

// Parses a number of bytes with an optional binary suffix K, M, G or T: "512", "16M", "2G", "1.5GiB". Fails with
// ErrorCode::usage.
[[nodiscard]] Result<std::uint64_t> parse_byte_size(std::string_view text);

// Formats with a binary unit: 1536 -> "1.5 KiB".
[[nodiscard]] std::string format_byte_size(std::uint64_t bytes);

}  // namespace isoextract

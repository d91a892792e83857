// Byte sizes as text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract {

// Parses a number of bytes with an optional binary suffix: "512", "16M", "2g", "1.5GiB"; 1 K, KB or KiB is 1024 bytes.
// Drops fractions of a byte. Fails with ErrorCode::usage for other texts and from 2^63 bytes on.
[[nodiscard]] Result<std::uint64_t> parse_byte_size(std::string_view text);

// Formats with a binary unit; from 1 KiB on, rounds to three significant digits: 1536 -> "1.5 KiB".
[[nodiscard]] std::string format_byte_size(std::uint64_t bytes);

}  // namespace isoextract

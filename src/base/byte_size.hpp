// Sizes in bytes as words.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract {

// "512", "16M", "2G", "1.5GiB": bytes with an optional binary suffix K, M, G, T. Fails with ErrorCode::usage.
[[nodiscard]] Result<std::uint64_t> parse_byte_size(std::string_view text);

// 1536 -> "1.5 KiB"
[[nodiscard]] std::string format_byte_size(std::uint64_t bytes);

}  // namespace isoextract

// Limits that sizes from files are held against before memory is taken.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/error.hpp"

namespace isoextract {

struct Limits {
  std::uint64_t memory_bytes;  // what one input may need in memory, mapped files apart; default: the machine's

  friend bool operator==(const Limits&, const Limits&) = default;
};

[[nodiscard]] Limits default_limits();

// "512", "16M", "2G", "1.5GiB": bytes with an optional binary suffix K, M, G, T. Fails with ErrorKind::usage.
[[nodiscard]] Result<std::uint64_t> parse_byte_size(std::string_view text);

// 1536 -> "1.5 KiB"
[[nodiscard]] std::string format_byte_size(std::uint64_t bytes);

// Fails with ErrorKind::input and names --memory-limit if `bytes` exceed the limit. `what` starts the message, for
// example "in.nrrd: 4096x4096x4096 float voxels".
[[nodiscard]] Result<void> check_memory(std::uint64_t bytes, const Limits& limits, const std::string& what);

}  // namespace isoextract

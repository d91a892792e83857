// Errors for failed allocations, with the limit of the process's address space.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.hpp"

namespace isoextract {

// Returns the limit of this process's address space (RLIMIT_AS, "ulimit -v") in bytes, or nothing if it is unlimited.
[[nodiscard]] std::optional<std::uint64_t> address_space_limit();

// Returns how much of that limit this process has left, or nothing if it is unlimited.
[[nodiscard]] std::optional<std::uint64_t> address_space_left();

// The step that tells how to raise that limit.
inline constexpr const char* kRaiseAddressSpaceHint =
    "raise that limit (ulimit -v unlimited; in a batch job, its limit of virtual memory)";

// Returns the error for a failed allocation, ErrorCode::out_of_memory. If the address space is limited, the message
// names the limit. A hint to raise the limit or to extract the volume in parts then replaces `hint`.
[[nodiscard]] Error allocation_error(std::string message, Hint hint = {});

}  // namespace isoextract

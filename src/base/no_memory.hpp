// Errors of allocations that failed, with what limits the process.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/error.hpp"

namespace isoextract {

// The limit of this process's address space (RLIMIT_AS, "ulimit -v") in bytes; nothing where it is unlimited.
[[nodiscard]] std::optional<std::uint64_t> address_space_limit();

// Tells how to raise that limit.
inline constexpr const char* kRaiseAddressSpace =
    "raise that limit (ulimit -v unlimited; in a batch job, its limit of virtual memory)";

// Returns the error of a failed allocation. Where the address space is limited, the message says so and the hint is to
// raise that limit: the machine's memory and the memory budget have nothing to do with it.
[[nodiscard]] Error no_memory(std::string message, Hint hint = {});

}  // namespace isoextract

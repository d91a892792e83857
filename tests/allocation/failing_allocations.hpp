// Counts the allocations of this program and lets one fail. Counts all forms of operator new, and the system calls of
// Buffer and MappedFile (tests.cmake wraps these), but not the allocations of C libraries. Allocations of libtinygltf
// never fail.
#pragma once

#include <cstdint>

namespace isoextract::test {

// Lets the `number`-th allocation from now on fail, on any thread; the first is 1.
void fail_allocation(std::uint64_t number);

// Returns whether that allocation was reached; no allocation fails from now on.
[[nodiscard]] bool allocation_reached();

// Returns the number of blocks of operator new that are not freed.
[[nodiscard]] std::int64_t live_allocations();

}  // namespace isoextract::test

// The allocations of this program: how many there are, and one that fails. What is counted is operator new in all its
// forms, and what Buffer and MappedFile ask the system for (tests.cmake wraps these); memory that libraries written in
// C take is not. What libtinygltf takes never fails.
#pragma once

#include <cstdint>

namespace isoextract::test {

// From now on the `number`-th allocation fails, on whatever thread it is; the first is 1.
void fail_allocation(std::uint64_t number);

// Whether there were so many; none fails from now on.
[[nodiscard]] bool allocation_reached();

// Blocks of operator new that were not given back.
[[nodiscard]] std::int64_t live_allocations();

}  // namespace isoextract::test

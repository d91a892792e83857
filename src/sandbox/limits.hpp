// What a child process may do that reads a file with a library that trusts it.
#pragma once

#include <cstdint>

namespace isoextract::sandbox {

struct Limits {
  std::uint64_t memory = 0;   // bytes that it may take, besides its libraries and the stacks of its threads
  std::uint64_t seconds = 0;  // that it may take, of the clock, and of each of its processors
  std::uint64_t threads = 1;
};

// Limits this process for good: memory, processor time, no files written, no core dumps; with the kernel's seccomp also
// no sockets, no programs started and no changes of the file system (detail/system_calls.hpp). What the system refuses
// is left out. The address space stays as it is where the address sanitizer needs all of it.
void apply(const Limits& limits);

}  // namespace isoextract::sandbox

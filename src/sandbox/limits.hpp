// Limits of a child process that reads a file with a library that does not validate its input.
#pragma once

#include <cstdint>

namespace isoextract::sandbox {

struct Limits {
  std::uint64_t memory = 0;  // bytes it may allocate; libraries, thread stacks and a reserve of 48 MiB do not count
  // Limit of wall-clock time, after which Worker ends the process. The limit of processor time is seconds * threads.
  std::uint64_t seconds = 0;
  std::uint64_t threads = 1;  // of oneTBB
};

// Limits this process permanently: memory, processor time, threads, no files written, no core dumps. With the kernel's
// seccomp it also cannot open sockets, start programs or change the file system (detail/system_calls.hpp). Ignores
// limits that the system does not support. Does not limit the memory under the address and thread sanitizers, which
// need all of the address space.
void apply(const Limits& limits);

}  // namespace isoextract::sandbox

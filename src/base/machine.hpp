// The machine, and the resources that this process uses.
#pragma once

#include <cstdint>
#include <string>

namespace isoextract {

// Returns the processor's name, such as "AMD EPYC 7763 64-Core Processor", or its architecture if /proc/cpuinfo has
// no name.
[[nodiscard]] std::string cpu_name();

// Returns the largest resident memory of this process so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory();

struct StartableThreads {
  int count = 0;
  std::string refusal;  // the system's reason if it allowed fewer; else empty
};
// Starts up to `wanted` threads that all live at the same time, ends them, and returns how many the system allowed.
[[nodiscard]] StartableThreads start_threads_together(int wanted);

}  // namespace isoextract

// The machine, and what this process has taken of it.
#pragma once

#include <cstdint>
#include <string>

namespace isoextract {

// The processor's name as the system tells it, "AMD EPYC 7763 64-Core Processor"; its architecture where it tells none.
[[nodiscard]] std::string cpu_name();

// The most memory that this process has held so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory();

// How many threads beside this one the system lets start, all of them at a time: `wanted`, or fewer, with its reason.
struct StartedThreads {
  int count = 0;
  std::string refusal;  // empty where all could
};
[[nodiscard]] StartedThreads try_threads(int wanted);

}  // namespace isoextract

#include "base/machine.hpp"

#include <exception>
#include <fstream>
#include <latch>
#include <thread>
#include <vector>

#include <sys/resource.h>
#include <sys/utsname.h>

namespace isoextract {

std::string cpu_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("model name")) continue;
    const std::size_t colon = line.find(": ");
    if (colon != std::string::npos) return line.substr(colon + 2);
  }
  utsname system{};
  return ::uname(&system) == 0 ? system.machine : "unknown";
}

std::uint64_t peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

StartableThreads start_threads_together(int wanted) {
  StartableThreads started;
  std::latch enough(1);
  std::vector<std::jthread> threads;
  try {
    for (int i = 0; i < wanted; ++i) threads.emplace_back([&] { enough.wait(); });
  } catch (const std::exception& error) {
    started.refusal = error.what();
  }
  started.count = static_cast<int>(threads.size());
  enough.count_down();
  return started;
}

}  // namespace isoextract

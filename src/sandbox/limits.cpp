#include "sandbox/limits.hpp"

#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include <tbb/global_control.h>

#include "base/checked.hpp"
#include "sandbox/detail/system_calls.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define ISOEXTRACT_SHADOW_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define ISOEXTRACT_SHADOW_MEMORY 1
#endif
#endif

namespace isoextract::sandbox {
namespace {

// Stack size of oneTBB's threads; the libraries that read volumes do not recurse deeply.
constexpr std::uint64_t kStackBytes = std::uint64_t{1} << 20;
// Memory that a library needs before it reads anything: stacks, code loaded on demand, the allocator's reserves.
constexpr std::uint64_t kSpareBytes = std::uint64_t{48} << 20;

// Sets a soft limit, and a hard limit that is `further` above it.
void limit(decltype(RLIMIT_AS) what, std::uint64_t value, std::uint64_t further = 0) {
  rlimit old{};
  static_cast<void>(::getrlimit(what, &old));
  const std::uint64_t hard = checked_sum(value, further).value_or(std::uint64_t{RLIM_INFINITY});
  const rlimit limited{std::min<std::uint64_t>(value, old.rlim_max), std::min<std::uint64_t>(hard, old.rlim_max)};
  static_cast<void>(::setrlimit(what, &limited));
}

#ifndef ISOEXTRACT_SHADOW_MEMORY
// Returns the current address space of this process in bytes.
std::uint64_t address_space() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  file >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}
#endif

void limit_memory(const Limits& limits) {
#ifdef ISOEXTRACT_SHADOW_MEMORY
  static_cast<void>(limits);
#else
  // Each additional malloc arena would use 64 MiB of the address space that the file may need.
  static_cast<void>(::mallopt(M_ARENA_MAX, 1));
  const auto stacks = checked_product(limits.threads, 2 * kStackBytes);
  const auto all = checked_sum(address_space(), kSpareBytes, stacks.value_or(0), limits.memory);
  limit(RLIMIT_AS, all.value_or(std::numeric_limits<std::uint64_t>::max()));
#endif
}

}  // namespace

void apply(const Limits& limits) {
  // Static: they hold until the process ends.
  static const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                           static_cast<std::size_t>(std::max<std::uint64_t>(limits.threads, 1)));
  static const tbb::global_control stacks(tbb::global_control::thread_stack_size, kStackBytes);
  limit(RLIMIT_CORE, 1);  // 1, not 0: it also keeps the system from starting programs that process core dumps
  limit(RLIMIT_FSIZE, 0);
  // The signal of the soft limit tells the parent why the worker ended.
  limit(RLIMIT_CPU, checked_product(limits.seconds, limits.threads).value_or(std::uint64_t{RLIM_INFINITY}), 2);
  limit_memory(limits);
  static_cast<void>(::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0));
  static_cast<void>(detail::restrict_system_calls());
}

}  // namespace isoextract::sandbox

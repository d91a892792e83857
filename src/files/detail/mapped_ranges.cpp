#include "files/detail/mapped_ranges.hpp"

#include <cerrno>
#include <csignal>

#include <sys/mman.h>
#include <unistd.h>

namespace isoextract::files::detail {
namespace {

static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<std::uintptr_t>::is_always_lock_free &&
                  std::atomic<bool>::is_always_lock_free && std::atomic<MappedRange*>::is_always_lock_free,
              "the handler may not lock");

std::atomic<MappedRange*> first_range{nullptr};

// Set before the handler is installed.
struct sigaction previous {};
std::uintptr_t page_size = 0;

// Returns the range that contains `address`. Skips entries that change meanwhile: the wanted entry cannot change, as
// its memory is in use.
MappedRange* find_range(std::uintptr_t address, std::uintptr_t& end) {
  for (MappedRange* range = first_range.load(std::memory_order_acquire); range != nullptr; range = range->next) {
    const std::uint64_t version = range->version.load(std::memory_order_acquire);
    if (version % 2 != 0) continue;
    const std::uintptr_t begin = range->begin.load(std::memory_order_acquire);
    end = range->end.load(std::memory_order_acquire);
    if (range->version.load(std::memory_order_relaxed) != version) continue;
    if (begin <= address && address < end) return range;
  }
  return nullptr;
}

// Replaces the pages from `address` to the end of its range by zeros. If the file was truncated, they are all missing;
// if the disk failed, the data is discarded anyway.
bool zero_lost_pages(const void* address) {
  const auto at = reinterpret_cast<std::uintptr_t>(address);
  std::uintptr_t end = 0;
  MappedRange* range = find_range(at, end);
  if (range == nullptr) return false;
  range->lost.store(true, std::memory_order_release);
  const std::uintptr_t page = at - at % page_size;
  void* const start = static_cast<char*>(const_cast<void*>(address)) - at % page_size;
  // Writable, because a temporary file may still be filled.
  return ::mmap(start, end - page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED | MAP_NORESERVE, -1,
                0) != MAP_FAILED;
}

// Calls the previous handler; without one, ends the process as if there were no handler.
void call_previous_handler(int signal, siginfo_t* info, void* context) {
  if ((previous.sa_flags & SA_SIGINFO) != 0) {
    previous.sa_sigaction(signal, info, context);
  } else if (previous.sa_handler == SIG_IGN && info->si_code <= 0) {  // sent by a process, so it may be ignored
    return;
  } else if (previous.sa_handler == SIG_DFL || previous.sa_handler == SIG_IGN) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  } else {
    previous.sa_handler(signal);
  }
}

extern "C" void on_bus_error(int signal, siginfo_t* info, void* context) {
  const int error = errno;
  const bool missing_page = info->si_code == BUS_ADRERR;
  if (!missing_page || !zero_lost_pages(info->si_addr)) call_previous_handler(signal, info, context);
  errno = error;
}

bool install_handler() {
  page_size = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  ::sigaction(SIGBUS, nullptr, &previous);
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  return ::sigaction(SIGBUS, &action, nullptr) == 0;
}

MappedRange* take_entry() {
  for (MappedRange* range = first_range.load(std::memory_order_acquire); range != nullptr; range = range->next) {
    if (!range->taken.exchange(true, std::memory_order_acquire)) return range;
  }
  auto* range = new MappedRange;
  range->version = 1;
  range->taken = true;
  range->next = first_range.load(std::memory_order_relaxed);
  while (!first_range.compare_exchange_weak(range->next, range, std::memory_order_release)) {
  }
  return range;
}

}  // namespace

MappedRange* watch_range(const void* pages, std::size_t length) {
  [[maybe_unused]] static const bool installed = install_handler();
  MappedRange* range = take_entry();
  const auto begin = reinterpret_cast<std::uintptr_t>(pages);
  range->begin.store(begin, std::memory_order_release);
  range->end.store(begin + length, std::memory_order_release);
  range->lost.store(false, std::memory_order_relaxed);
  range->version.fetch_add(1, std::memory_order_release);
  return range;
}

void unwatch_range(MappedRange* range) {
  range->version.fetch_add(1, std::memory_order_acq_rel);
  range->taken.store(false, std::memory_order_release);
}

}  // namespace isoextract::files::detail

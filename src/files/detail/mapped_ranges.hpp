// The mapped ranges in a form that a signal handler can read. The handler replaces a missing page and all later
// pages of its range by zeros, and marks the range as lost.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace isoextract::files::detail {

// An entry of the table. Entries are reused and never freed, as the handler may read them at any time.
struct MappedRange {
  std::atomic<std::uint64_t> version{0};  // odd while the entry is unused or changes
  std::atomic<std::uintptr_t> begin{0};
  std::atomic<std::uintptr_t> end{0};
  std::atomic<bool> lost{false};
  std::atomic<bool> taken{false};
  MappedRange* next = nullptr;  // set before the entry is published
};

// Handles bus errors within [pages, pages + length) from now on; `pages` is the start of a page. The first call
// installs the handler. May throw std::bad_alloc.
[[nodiscard]] MappedRange* watch_range(const void* pages, std::size_t length);

// Stops watching a range; call before unmapping it, and do not use `range` afterwards.
void unwatch_range(MappedRange* range);

}  // namespace isoextract::files::detail

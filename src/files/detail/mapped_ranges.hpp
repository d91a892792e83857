// The ranges of memory that are mapped files, as a signal handler can look at them: what a file no longer has is
// replaced by zeros, and its range is marked.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace isoextract::files::detail {

// An entry of the table. Entries are used again and never freed: the handler may be looking at them at any time.
struct MappedRange {
  std::atomic<std::uint64_t> version{0};  // odd: not in use, or about to change
  std::atomic<std::uintptr_t> begin{0};
  std::atomic<std::uintptr_t> end{0};
  std::atomic<bool> lost{false};
  std::atomic<bool> taken{false};
  MappedRange* next = nullptr;  // set before the entry can be seen
};

// From now on bus errors within [pages, pages + length), which begins at a page, are dealt with. The first call
// installs the handler. May throw std::bad_alloc.
[[nodiscard]] MappedRange* watch_range(const void* pages, std::size_t length);

// Before the range is unmapped. `range` is not to be looked at afterwards.
void forget_range(MappedRange* range);

}  // namespace isoextract::files::detail

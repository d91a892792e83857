#include "base/pages.hpp"

#include <algorithm>
#include <cstdint>

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/buffer.hpp"

namespace isoextract {
namespace {

std::size_t page_size() {
  static const auto size = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  return size;
}

// Only advice: if the system ignores it, nothing changes but the time. `begin` must be the start of a page.
void advise(const std::byte* begin, std::size_t bytes, int advice) {
  static_cast<void>(::madvise(const_cast<std::byte*>(begin), bytes, advice));
}

}  // namespace

void release_pages(const void* begin, std::size_t bytes) {
  const std::size_t page = page_size();
  const std::size_t within = reinterpret_cast<std::uintptr_t>(begin) % page;
  const std::size_t lead = (page - within) % page;  // before the first whole page
  if (bytes < lead + page) return;
  const std::size_t whole = (bytes - lead) / page * page;
  // The pages stay if the system ignores this. The read-only mapping itself does not change.
  advise(static_cast<const std::byte*>(begin) + lead, whole, MADV_DONTNEED);
}

PageRequests::PageRequests(const void* begin, std::size_t bytes)
    : begin_(static_cast<const std::byte*>(begin)), bytes_(bytes), is_requested_((bytes + kBlock - 1) / kBlock) {}

void PageRequests::come_to(const void* place) {
  if (is_requested_.empty()) return;
  const auto at = static_cast<std::size_t>(static_cast<const std::byte*>(place) - begin_);
  const std::size_t last = std::min(is_requested_.size(), (at + kAhead - 1) / kBlock + 1);
  for (std::size_t block = at / kBlock; block < last; ++block) {
    std::atomic<bool>& is_requested = is_requested_[block];
    const bool was_requested = is_requested.load(std::memory_order_relaxed) || is_requested.exchange(true);
    if (!was_requested) request(block);
  }
}

// Of a long request, Linux reads the missing pages of the first part only: as much as the device takes at once, which
// is 128 KiB or more. Requests of pages that are being read cost a microsecond.
void PageRequests::request(std::size_t block) const {
  constexpr std::size_t kLeastRead = std::size_t{1} << 17U;
  const std::size_t end = std::min((block + 1) * kBlock, bytes_);
  for (std::size_t at = block * kBlock; at < end; at += kLeastRead) {
    const std::size_t within = reinterpret_cast<std::uintptr_t>(begin_ + at) % page_size();
    advise(begin_ + at - within, within + end - at, MADV_WILLNEED);
  }
}

void return_large_blocks() { static_cast<void>(::mallopt(M_MMAP_THRESHOLD, 1 << 20)); }

void release_free_memory() {
  detail::trim_kept_blocks(0);
  static_cast<void>(::malloc_trim(0));
}

}  // namespace isoextract

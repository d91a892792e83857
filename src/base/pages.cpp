#include "base/pages.hpp"

#include <cstdint>

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/buffer.hpp"

namespace isoextract {

void release_pages(const void* begin, std::size_t bytes) {
  static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  const auto within = static_cast<std::size_t>(reinterpret_cast<std::uintptr_t>(begin) % page);
  const std::size_t lead = (page - within) % page;  // before the first whole page
  if (bytes < lead + page) return;
  const std::size_t whole = (bytes - lead) / page * page;
  // Only advice: if the system ignores it, the pages stay. The read-only mapping itself does not change.
  static_cast<void>(::madvise(static_cast<char*>(const_cast<void*>(begin)) + lead, whole, MADV_DONTNEED));
}

void return_large_blocks() { static_cast<void>(::mallopt(M_MMAP_THRESHOLD, 1 << 20)); }

void release_free_memory() {
  detail::trim_kept_blocks(0);
  static_cast<void>(::malloc_trim(0));
}

}  // namespace isoextract

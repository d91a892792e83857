#include "base/pages.hpp"

#include <cstdint>

#include <sys/mman.h>
#include <unistd.h>

namespace isoextract {

void give_back_pages(const void* begin, std::size_t bytes) {
  static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto first = reinterpret_cast<std::uintptr_t>(begin);
  const std::uintptr_t start = (first + page - 1) / page * page;
  const std::uintptr_t end = (first + bytes) / page * page;
  // Advice only: where the system does not take it, the pages stay.
  if (start < end) static_cast<void>(::madvise(reinterpret_cast<void*>(start), end - start, MADV_DONTNEED));
}

}  // namespace isoextract

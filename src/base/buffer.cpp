#include "base/buffer.hpp"

#include <cstdint>
#include <cstdlib>
#include <new>

#include <sys/mman.h>

namespace isoextract::detail {

void* allocate_pages(std::size_t count, std::size_t size) {
  constexpr std::size_t kCacheLine = 64;
  constexpr std::size_t kHugePage = std::size_t{2} << 20;
  if (count == 0) return nullptr;
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - kHugePage) throw std::bad_alloc();
  const bool huge = bytes >= 2 * kHugePage;
  const std::size_t alignment = huge ? kHugePage : kCacheLine;
  void* block = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
  if (block == nullptr) throw std::bad_alloc();
  // Advice only: where the system does not know huge pages nothing is lost.
  if (huge) static_cast<void>(::madvise(block, bytes, MADV_HUGEPAGE));
  return block;
}

void free_pages(void* block) { std::free(block); }

}  // namespace isoextract::detail

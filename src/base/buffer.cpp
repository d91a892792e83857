#include "base/buffer.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>
#include <vector>

namespace isoextract::detail {
namespace {

constexpr std::size_t kCacheLine = 64;
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;  // blocks from this size on have huge pages, and are kept

// Large blocks that were given back. A sequence of frames needs blocks of about the same sizes again and again, and to
// have the system clear pages for a mesh takes longer than to extract it.
class KeptBlocks {
 public:
  // A block of `bytes` or little more, or null.
  void* take(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    auto best = blocks_.end();
    for (auto block = blocks_.begin(); block != blocks_.end(); ++block) {
      if (block->bytes < bytes || block->bytes - bytes > bytes / 2) continue;
      if (best == blocks_.end() || block->bytes < best->bytes) best = block;
    }
    if (best == blocks_.end()) return nullptr;
    void* const found = best->start;
    total_ -= best->bytes;
    blocks_.erase(best);
    return found;
  }

  // Makes room by letting go of those that waited longest.
  void keep(void* start, std::size_t bytes) {
    std::vector<Block> gone;
    {
      const std::scoped_lock lock(mutex_);
      const auto last = std::ranges::find_if(blocks_, [&](const Block& block) {
        if (total_ + bytes <= limit_) return true;
        total_ -= block.bytes;
        return false;
      });
      gone.assign(blocks_.begin(), last);
      blocks_.erase(blocks_.begin(), last);
      if (bytes <= limit_) {
        blocks_.push_back({start, bytes});
        total_ += bytes;
      } else {
        gone.push_back({start, bytes});
      }
    }
    for (const Block& block : gone) std::free(block.start);
  }

  // All of them; false if there were none.
  bool release() {
    std::vector<Block> gone;
    {
      const std::scoped_lock lock(mutex_);
      gone.swap(blocks_);
      total_ = 0;
    }
    for (const Block& block : gone) std::free(block.start);
    return !gone.empty();
  }

 private:
  struct Block {
    void* start;
    std::size_t bytes;
  };

  // Of all kept blocks together: a sixteenth of the machine's memory.
  static std::size_t choose_limit() {
    constexpr std::size_t kShare = 16;
    const auto pages = ::sysconf(_SC_PHYS_PAGES);
    const auto page = ::sysconf(_SC_PAGESIZE);
    return pages > 0 && page > 0 ? static_cast<std::size_t>(pages) / kShare * static_cast<std::size_t>(page) : 0;
  }

  std::mutex mutex_;
  std::vector<Block> blocks_;  // the one kept longest first
  std::size_t total_ = 0;
  std::size_t limit_ = choose_limit();
};

// Never destroyed: buffers may outlive everything that has a destructor.
KeptBlocks& kept_blocks() {
  static auto* const kept = new KeptBlocks;
  return *kept;
}

}  // namespace

void* allocate_pages(std::size_t count, std::size_t size) {
  if (count == 0) return nullptr;
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - kHugePage) throw std::bad_alloc();
  const bool large = bytes >= kLarge;
  if (large) {
    if (void* const kept = kept_blocks().take(bytes); kept != nullptr) return kept;
  }
  const std::size_t alignment = large ? kHugePage : kCacheLine;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* block = std::aligned_alloc(alignment, rounded);
  if (block == nullptr && kept_blocks().release()) block = std::aligned_alloc(alignment, rounded);
  if (block == nullptr) throw std::bad_alloc();
  // Advice only: where the system does not know huge pages nothing is lost.
  if (large) static_cast<void>(::madvise(block, bytes, MADV_HUGEPAGE));
  return block;
}

void free_pages(void* block) {
  const std::size_t bytes = ::malloc_usable_size(block);
#ifdef __SANITIZE_ADDRESS__
  const bool keep = false;  // what is used after it was given back must be found
#else
  const bool keep = bytes >= kLarge;
#endif
  if (keep) {
    kept_blocks().keep(block, bytes);
  } else {
    std::free(block);
  }
}

}  // namespace isoextract::detail

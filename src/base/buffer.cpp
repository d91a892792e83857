#include "base/buffer.hpp"

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <new>
#include <utility>

#if defined(__SANITIZE_ADDRESS__)
#define ISOEXTRACT_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ISOEXTRACT_ADDRESS_SANITIZER 1
#endif
#endif

namespace isoextract::detail {
namespace {

constexpr std::size_t kCacheLine = 64;
constexpr std::size_t kHugePage = std::size_t{2} << 20;
constexpr std::size_t kLarge = 2 * kHugePage;  // blocks of this size and more use huge pages and are kept for reuse
constexpr std::size_t kSlack = 2 * kHugePage;  // the most that rounding and alignment can add to a block

// Freed large blocks, kept for reuse. Repeated extractions (several iso values, benchmark rounds) need blocks of
// similar sizes, and the system takes longer to clear the pages of a mesh than an extraction takes.
class BlockCache {
 public:
  // Returns the smallest kept block of at least `bytes` and at most bytes * 1.5 + kSlack. Without one, returns null and
  // frees all blocks below `bytes`, because the sizes have changed.
  void* take(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    Block* best = nullptr;
    for (Block& block : blocks_) {
      if (block.bytes < bytes || block.bytes - bytes > bytes / 2 + kSlack) continue;
      if (best == nullptr || block.bytes < best->bytes) best = &block;
    }
    if (best != nullptr) {
      total_ -= best->bytes;
      return std::exchange(*best, {}).start;
    }
    for (Block& block : blocks_) {
      if (block.bytes < bytes) let_go(block);
    }
    return nullptr;
  }

  // Keeps a block in the place of the oldest one, and frees more of the oldest blocks to stay within the limit.
  void keep(void* start, std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    if (bytes > limit_) {
      std::free(start);
      return;
    }
    for (std::size_t tried = 0; tried < blocks_.size() && total_ + bytes > limit_; ++tried) {
      let_go(blocks_[(next_ + tried) % blocks_.size()]);
    }
    Block& place = blocks_[next_];
    next_ = (next_ + 1) % blocks_.size();
    let_go(place);
    place = {start, bytes};
    total_ += bytes;
  }

  // Frees the oldest blocks until at most `bytes` are left. Returns false if there was nothing to free.
  bool trim_to(std::size_t bytes) {
    const std::scoped_lock lock(mutex_);
    const bool any = total_ > bytes;
    for (std::size_t tried = 0; tried < blocks_.size() && total_ > bytes; ++tried) {
      let_go(blocks_[(next_ + tried) % blocks_.size()]);
    }
    return any;
  }

 private:
  struct Block {
    void* start = nullptr;
    std::size_t bytes = 0;
  };

  void let_go(Block& block) {
    total_ -= block.bytes;
    std::free(std::exchange(block, {}).start);
  }

  // Returns the limit for the sum of all kept blocks.
  static std::size_t choose_limit() {
    constexpr std::size_t kMost = std::size_t{512} << 20;
    constexpr std::size_t kShare = 16;  // of the machine's memory
    const auto pages = ::sysconf(_SC_PHYS_PAGES);
    const auto page = ::sysconf(_SC_PAGESIZE);
    if (pages <= 0 || page <= 0) return 0;
    return std::min(kMost, static_cast<std::size_t>(pages) / kShare * static_cast<std::size_t>(page));
  }

  std::mutex mutex_;
  std::array<Block, 16> blocks_{};
  std::size_t next_ = 0;  // the place of the oldest block, where the next one goes
  std::size_t total_ = 0;
  std::size_t limit_ = choose_limit();
};

// Never destroyed, because a buffer may outlive every static object.
BlockCache& block_cache() {
  static auto* const kept = new BlockCache;
  return *kept;
}

}  // namespace

void* allocate_block(std::size_t count, std::size_t size) {
  if (count == 0) return nullptr;
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes) || bytes > PTRDIFF_MAX - kHugePage) throw std::bad_alloc();
  const bool large = bytes >= kLarge;
  if (large) {
    if (void* const kept = block_cache().take(bytes); kept != nullptr) return kept;
  }
  const std::size_t alignment = large ? kHugePage : kCacheLine;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* block = std::aligned_alloc(alignment, rounded);
  if (block == nullptr && block_cache().trim_to(0)) block = std::aligned_alloc(alignment, rounded);
  if (block == nullptr) throw std::bad_alloc();
  // Only advice: without huge pages the block works as well.
  if (large) static_cast<void>(::madvise(block, bytes, MADV_HUGEPAGE));
  return block;
}

void free_block(void* block) {
  const std::size_t bytes = ::malloc_usable_size(block);
#ifdef ISOEXTRACT_ADDRESS_SANITIZER
  const bool keep = false;  // so that the sanitizer finds uses after free
#else
  const bool keep = bytes >= kLarge && reinterpret_cast<std::uintptr_t>(block) % kHugePage == 0;
#endif
  if (keep) {
    block_cache().keep(block, bytes);
  } else {
    std::free(block);
  }
}

void trim_kept_blocks(std::uint64_t bytes) { block_cache().trim_to(bytes); }

}  // namespace isoextract::detail

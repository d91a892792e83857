// Memory for the bits of label parts that are moved to files.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "extract/detail/label_parts.hpp"
#include "extract/detail/net_memory.hpp"

namespace isoextract::extract {

// Owns the bits. Safe to use from several threads.
class LabelBits {
 public:
  // `memory` must outlive the object.
  explicit LabelBits(NetMemory& memory) : memory_(memory) {}

  // Counts the bits of a list that gets no more parts. Once the bits of all lists take much of the memory limit, moves
  // them to a file; keeps them in the list if no file can be had.
  void place(LabelPartList& list) {
    const std::uint64_t bytes = list.own_bits() * sizeof(ChunkBits);
    if (in_memory_.fetch_add(bytes) + bytes <= most_in_memory(memory_.context())) return;
    memory_.use_files();
    if (auto to = take(list.own_bits())) {
      list.move_bits(*to);
      in_memory_.fetch_sub(bytes);
    }
    memory_.leave();
  }

  // Returns how many bytes of bits stay in memory: a part of the limit, since the points of a net take more later.
  [[nodiscard]] static std::uint64_t most_in_memory(const Context& context) { return context.memory().limit() / 8; }

 private:
  // Returns place for `count` elements.
  [[nodiscard]] Result<std::span<ChunkBits>> take(std::size_t count) {
    const std::lock_guard lock(mutex_);
    if (files_.empty() || files_.back().size() - used_ < count) {
      // Each file is larger than the one before, so that there are few.
      constexpr std::size_t kLeast = (std::size_t{32} << 20U) / sizeof(ChunkBits);
      const std::size_t size = std::max({kLeast, count, files_.empty() ? 0 : files_.back().size() * 3 / 2});
      auto file = TRY(memory_.make<ChunkBits>(size));
      files_.push_back(std::move(file));
      used_ = 0;
    }
    const std::span<ChunkBits> taken = files_.back().span().subspan(used_, count);
    used_ += count;
    return taken;
  }

  NetMemory& memory_;
  std::atomic<std::uint64_t> in_memory_ = 0;
  std::mutex mutex_;
  std::vector<NetArray<ChunkBits>> files_;
  std::size_t used_ = 0;  // elements of the last file
};

}  // namespace isoextract::extract

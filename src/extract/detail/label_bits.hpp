// Memory for the bits of label parts that are moved to files.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "extract/detail/label_parts.hpp"
#include "extract/detail/net_memory.hpp"

namespace isoextract::extract {

// Owns the bits. Safe to use from several threads.
class LabelBits {
 public:
  // `memory` must outlive the object. `nets`: the labels get a net, whose arrays need memory later.
  LabelBits(NetMemory& memory, bool nets) : memory_(memory), most_in_memory_(most_in_memory(memory.context(), nets)) {}

  // Counts the bits of a list that gets no more parts. Once the bits of all lists take more than most_in_memory(),
  // moves them to a file; keeps them in the list if there is no file.
  void place(LabelPartList& list) {
    const std::uint64_t bytes = list.own_bits() * sizeof(ChunkBits);
    if (in_memory_.fetch_add(bytes) + bytes <= most_in_memory_ || bytes == 0) return;
    const std::optional<std::span<ChunkBits>> to = take(list.own_bits());
    if (!to) return;
    list.move_bits(*to);
    in_memory_.fetch_sub(bytes);
    memory_.leave_after(bytes);
  }

  // Returns how many bytes of bits stay in memory.
  [[nodiscard]] static std::uint64_t most_in_memory(const Context& context, bool nets) {
    constexpr std::uint64_t kLeast = std::uint64_t{8} << 20U;
    return std::max(context.memory().limit() / (nets ? 8 : 2), kLeast);
  }

  // Adds why there is no file to an error about memory.
  [[nodiscard]] Error explain(Error refusal) {
    const std::lock_guard lock(mutex_);
    if (!no_file_) return refusal;
    refusal.message += no_file_->message;
    std::ranges::copy(no_file_->hint.steps, std::back_inserter(refusal.hint.steps));
    return refusal;
  }

 private:
  // Returns space for `count` elements; nothing if there is no file.
  [[nodiscard]] std::optional<std::span<ChunkBits>> take(std::size_t count) {
    const std::lock_guard lock(mutex_);
    if (no_file_) return std::nullopt;
    if (files_.empty() || files_.back().size() - used_ < count) {
      // Each file is larger than the one before, so that there are few.
      constexpr std::size_t kLeast = (std::size_t{32} << 20U) / sizeof(ChunkBits);
      const std::size_t size = std::max({kLeast, count, files_.empty() ? 0 : files_.back().size() * 3 / 2});
      auto file = memory_.make_in_file<ChunkBits>(size, Error{ErrorCode::out_of_memory, {}, {}});
      if (!file) {
        no_file_ = std::move(file.error());
        return std::nullopt;
      }
      memory_.use_files();
      files_.push_back(std::move(*file));
      used_ = 0;
    }
    const std::span<ChunkBits> taken = files_.back().span().subspan(used_, count);
    used_ += count;
    return taken;
  }

  NetMemory& memory_;
  std::uint64_t most_in_memory_;
  std::atomic<std::uint64_t> in_memory_ = 0;
  std::mutex mutex_;
  std::vector<NetArray<ChunkBits>> files_;
  std::size_t used_ = 0;  // elements of the last file
  std::optional<Error> no_file_;
};

}  // namespace isoextract::extract

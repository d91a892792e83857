// Progress of a long stage, for `cli` to read from another thread. Long-running functions report through
// Context::progress(). Functions without a context take a `Progress*`, which may be null. These functions do not print.
#pragma once

#include <atomic>
#include <cstdint>

namespace isoextract {

class Progress {
 public:
  // Begins a stage; `stage` must be a string literal. The unit of `total` depends on the stage (bytes, bricks, frames).
  // A total of 0 means unknown.
  void begin(const char* stage, std::uint64_t total) {
    done_.store(0, std::memory_order_relaxed);
    total_.store(total, std::memory_order_relaxed);
    stage_.store(stage, std::memory_order_release);
  }
  void advance(std::uint64_t units) { done_.fetch_add(units, std::memory_order_relaxed); }

  [[nodiscard]] const char* stage() const { return stage_.load(std::memory_order_acquire); }
  [[nodiscard]] std::uint64_t done() const { return done_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t total() const { return total_.load(std::memory_order_relaxed); }

 private:
  std::atomic<const char*> stage_{""};
  std::atomic<std::uint64_t> done_{0};
  std::atomic<std::uint64_t> total_{0};
};

}  // namespace isoextract

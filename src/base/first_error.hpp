// Keeps the first error of several threads.
#pragma once

#include <atomic>
#include <mutex>
#include <optional>
#include <utility>

#include "base/error.hpp"

namespace isoextract {

class FirstError {
 public:
  // Keeps the error, unless there is one already.
  void keep(Error error) {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    any_.store(true, std::memory_order_relaxed);
  }
  [[nodiscard]] bool any() const { return any_.load(std::memory_order_relaxed); }
  // Call it when the threads are done.
  [[nodiscard]] std::optional<Error>& error() { return error_; }

 private:
  std::mutex mutex_;
  std::atomic<bool> any_{false};
  std::optional<Error> error_;
};

}  // namespace isoextract

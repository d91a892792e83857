// The time during which tasks run, on one thread or on several.
#pragma once

#include <cstddef>
#include <mutex>
#include <utility>

#include "base/stopwatch.hpp"

namespace isoextract {

// Measures the time during which at least one task runs: tasks side by side count once.
class ActiveTime {
 public:
  // A task that runs as long as this object lives. Null: measures nothing.
  class Task {
   public:
    explicit Task(ActiveTime* of) : of_(of) {
      if (of_ != nullptr) of_->begin();
    }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;
    ~Task() {
      if (of_ != nullptr) of_->end();
    }

   private:
    ActiveTime* of_;
  };

  // Returns the time until the last task ended, and begins again at 0. No task may run.
  [[nodiscard]] StageTime take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(taken_, {});
  }

 private:
  void begin() {
    const std::scoped_lock lock(mutex_);
    if (running_++ == 0) watch_.restart();
  }
  void end() {
    const std::scoped_lock lock(mutex_);
    if (--running_ == 0) taken_ += watch_.elapsed();
  }

  std::mutex mutex_;
  std::size_t running_ = 0;
  Stopwatch watch_;
  StageTime taken_;
};

}  // namespace isoextract

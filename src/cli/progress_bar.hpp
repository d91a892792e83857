// A bar on stderr for work that takes over a second, where stderr is a terminal; otherwise nothing at all.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "base/progress.hpp"

namespace isoextract::cli {

// Lives as long as the work; draws from a thread of its own and erases itself at the end. Nothing else may write to
// stderr meanwhile.
class ProgressBar {
 public:
  // `watched`: in place of a progress of its own.
  explicit ProgressBar(bool wanted, Progress* watched = nullptr);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // For the rooms that do the work.
  [[nodiscard]] Progress* progress() { return watched_; }

 private:
  void draw_until_done();

  Progress own_;
  Progress* watched_;
  std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false;
  std::thread thread_;
};

}  // namespace isoextract::cli

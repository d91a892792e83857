// A bar on stderr for work that takes over a second, where stderr is a terminal and a thread can be had to draw it;
// otherwise nothing at all.
#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "base/progress.hpp"

namespace isoextract::cli {

// Lives as long as the work; draws from a thread of its own and erases itself at the end. Who writes to stderr
// meanwhile does so within above().
class ProgressBar {
 public:
  ProgressBar(const Progress& progress, bool wanted);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Erases the bar, calls `print` and lets the bar come back below.
  template <class Print>
  void above(Print&& print) {
    const std::lock_guard lock(mutex_);
    erase();
    print();
  }

 private:
  void draw_until_done();
  void erase();

  const Progress& progress_;
  std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false;
  bool drawn_ = false;  // it stands on the terminal
  std::thread thread_;
};

}  // namespace isoextract::cli

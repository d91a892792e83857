// A bar on stderr for work that takes over a second, where stderr is a terminal and a thread can be had to draw it;
// otherwise nothing, or a line every half a minute where that is asked for.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/progress.hpp"

namespace isoextract::cli {

// Lives as long as the work; draws from a thread of its own and erases itself at the end. Who writes to stderr
// meanwhile does so within above().
class ProgressBar {
 public:
  // `text` says what stands behind the bar, in place of the stage; it is called from the bar's thread. With `lines` it
  // is printed as lines where stderr is no terminal.
  ProgressBar(const Progress& progress, bool wanted, std::function<std::string()> text = {}, bool lines = false);
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
  void print_until_done();
  void erase();

  const Progress& progress_;
  std::function<std::string()> text_;
  std::mutex mutex_;
  std::condition_variable finished_;
  bool done_ = false;
  bool drawn_ = false;  // it stands on the terminal
  std::thread thread_;
};

}  // namespace isoextract::cli

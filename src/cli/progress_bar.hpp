// Shows a progress bar on stderr for work of more than a second, if stderr is a terminal. Otherwise prints nothing or,
// if requested, a line every half minute. Shows neither if the system cannot start a thread.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/progress.hpp"

namespace isoextract::cli {

// Draws a bar in its own thread after one second of work, and erases it when destroyed. While the object exists, write
// to stderr only within above().
class ProgressBar {
 public:
  // Shows nothing unless `wanted`. Draws if stderr is a terminal; otherwise prints a line every 30 s if `lines` is set.
  // `text` replaces the name of the stage; the bar's thread calls it, and it must not call above(), which would
  // deadlock. `progress` must outlive the bar.
  ProgressBar(const Progress& progress, bool wanted, std::function<std::string()> text = {}, bool lines = false);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  // Erases the bar, calls `print`, and redraws the bar below it later.
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
  bool drawn_ = false;  // the bar is visible
  std::thread thread_;
};

}  // namespace isoextract::cli

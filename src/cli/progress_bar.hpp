// Shows a progress bar on stderr for work of more than a second, if stderr is a terminal and a thread for the bar
// starts. Otherwise prints nothing or, if requested, a line every half minute.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "base/progress.hpp"

namespace isoextract::cli {

// Lives as long as the work. Draws in its own thread and erases the bar at the end. Write to stderr only within above()
// meanwhile.
class ProgressBar {
 public:
  // `text` replaces the name of the stage behind the bar; it is called in the bar's thread. With `lines`, prints it as
  // lines if stderr is not a terminal.
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

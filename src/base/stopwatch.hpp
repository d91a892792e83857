// Wall and CPU time of a stage.
#pragma once

#include <chrono>
#include <ctime>

namespace isoextract {

struct StageTime {
  double wall_seconds = 0;
  double cpu_seconds = 0;  // of the whole process, summed over its threads

  StageTime& operator+=(const StageTime& other) {
    wall_seconds += other.wall_seconds;
    cpu_seconds += other.cpu_seconds;
    return *this;
  }
};

class Stopwatch {
 public:
  Stopwatch() { restart(); }

  void restart() {
    wall_ = std::chrono::steady_clock::now();
    cpu_ = cpu_now();
  }

  [[nodiscard]] StageTime elapsed() const {
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count(), cpu_now() - cpu_};
  }

 private:
  static double cpu_now() {
    timespec t{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }

  std::chrono::steady_clock::time_point wall_;
  double cpu_ = 0;
};

}  // namespace isoextract

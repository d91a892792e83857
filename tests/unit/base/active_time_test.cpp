#include "base/active_time.hpp"

#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

void wait() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }

TEST(ActiveTime, CountsTasksSideBySideOnce) {
  ActiveTime time;
  const Stopwatch all;
  std::optional<ActiveTime::Task> first(std::in_place, &time);
  std::optional<ActiveTime::Task> second(std::in_place, &time);
  wait();
  first.reset();
  wait();
  second.reset();
  const double whole = all.elapsed().wall_seconds;
  const double taken = time.take().wall_seconds;
  EXPECT_GE(taken, 0.039);
  EXPECT_LE(taken, whole);
  EXPECT_EQ(time.take().wall_seconds, 0);
}

TEST(ActiveTime, LeavesOutTheTimeBetweenTasks) {
  ActiveTime time;
  double in_tasks = 0;
  for (int i = 0; i < 2; ++i) {
    const Stopwatch watch;
    { const ActiveTime::Task task(&time); }
    in_tasks += watch.elapsed().wall_seconds;
    const ActiveTime::Task none(nullptr);
    wait();
  }
  EXPECT_LE(time.take().wall_seconds, in_tasks);
}

}  // namespace
}  // namespace isoextract

#include "batch/detail/frame_queue.hpp"

#include <algorithm>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::batch {
namespace {

using Turn = FrameQueue::Turn;

void start(FrameQueue& queue, std::size_t place) {
  ASSERT_EQ(queue.next(), place);
  queue.start(place);
}

TEST(FrameQueue, RepeatsAloneAtEndWithoutOrder) {
  FrameQueue queue(4, false);
  start(queue, 0);
  start(queue, 1);
  queue.run_again_alone(0);
  EXPECT_EQ(queue.left(), 3U);
  start(queue, 2);
  start(queue, 3);
  EXPECT_EQ(queue.next(), std::nullopt);  // others are running
  queue.end(1);
  queue.run_again_alone(3);
  EXPECT_EQ(queue.next(), std::nullopt);
  queue.end(2);
  start(queue, 0);
  EXPECT_TRUE(queue.is_alone(0));
  EXPECT_EQ(queue.next(), std::nullopt);
  queue.end(0);
  start(queue, 3);
  queue.end(3);
  EXPECT_EQ(queue.next(), std::nullopt);
  EXPECT_EQ(queue.left(), 0U);
}

TEST(FrameQueue, WaitsForEarlierFramesInOrder) {
  FrameQueue queue(3, true);
  for (const std::size_t place : {0U, 1U, 2U}) start(queue, place);
  EXPECT_EQ(queue.turn(2), Turn::later);
  EXPECT_EQ(queue.turn(1), Turn::later);
  EXPECT_EQ(queue.turn(0), Turn::now);
  queue.end(1);  // failed, so it needs no turn
  EXPECT_EQ(queue.turn(2), Turn::later);
  queue.end(0);
  EXPECT_EQ(queue.turn(2), Turn::now);
}

TEST(FrameQueue, PostponesLaterFramesInOrder) {
  FrameQueue queue(6, true);
  for (const std::size_t place : {0U, 1U, 2U, 3U}) start(queue, place);
  queue.run_again_alone(1);
  EXPECT_EQ(queue.turn(0), Turn::now);
  EXPECT_EQ(queue.turn(2), Turn::turned_away);
  EXPECT_EQ(queue.turn(3), Turn::turned_away);
  EXPECT_EQ(queue.next(), std::nullopt);
  queue.end(3);  // failed while turned away: it ends all the same
  queue.run_again(2);
  EXPECT_EQ(queue.next(), std::nullopt);  // frame 0 still runs
  queue.end(0);
  start(queue, 1);
  EXPECT_TRUE(queue.is_alone(1));
  EXPECT_EQ(queue.next(), std::nullopt);
  EXPECT_EQ(queue.turn(1), Turn::now);
  queue.end(1);
  for (const std::size_t place : {2U, 4U, 5U}) start(queue, place);  // side by side again
  EXPECT_EQ(queue.turn(2), Turn::now);
  EXPECT_EQ(queue.turn(5), Turn::later);
  EXPECT_EQ(queue.left(), 0U);
}

// Some frame can always go on, and each frame is handed over once, in order.
TEST(FrameQueue, NeverStallsInOrder) {
  std::mt19937 chance(7);
  for (int round = 0; round < 300; ++round) {
    const std::size_t count = 1 + chance() % 12;
    const std::size_t jobs = 1 + chance() % 4;
    FrameQueue queue(count, true);
    std::vector<std::size_t> running;
    std::vector<std::size_t> taken;
    std::vector<bool> over(count, false);
    const auto leave = [&](std::size_t at) { running.erase(running.begin() + static_cast<std::ptrdiff_t>(at)); };
    for (int step = 0; queue.left() > 0 || !running.empty(); ++step) {
      ASSERT_LT(step, 10000);
      if (const auto place = queue.next(); place && running.size() < jobs) {
        ASSERT_TRUE(running.empty() || !queue.is_alone(*place));
        for (const std::size_t other : running) ASSERT_FALSE(queue.is_alone(other));
        queue.start(*place);
        running.push_back(*place);
        continue;
      }
      // At least one running frame is not told to wait.
      const auto can_go = [&](std::size_t place) { return queue.turn(place) != Turn::later; };
      ASSERT_TRUE(std::ranges::any_of(running, can_go));
      const std::size_t at = chance() % running.size();
      const std::size_t place = running[at];
      const bool beside_others = running.size() > 1;
      if (beside_others && chance() % 8 == 0) {  // out of memory
        queue.run_again_alone(place);
      } else if (chance() % 8 == 0) {  // another failure
        queue.end(place);
        over[place] = true;
      } else if (queue.turn(place) == Turn::turned_away) {
        queue.run_again(place);
      } else if (queue.turn(place) == Turn::now) {
        for (std::size_t before = 0; before < place; ++before) ASSERT_TRUE(over[before]);
        queue.end(place);
        over[place] = true;
        taken.push_back(place);
      } else {
        continue;
      }
      leave(at);
    }
    EXPECT_TRUE(std::ranges::is_sorted(taken));
    EXPECT_EQ(std::ranges::count(over, false), 0);
  }
}

}  // namespace
}  // namespace isoextract::batch

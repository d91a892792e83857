#include "base/memory_budget.hpp"

#include <atomic>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "base/buffer.hpp"
#include "base/context.hpp"

namespace isoextract {
namespace {

TEST(MemoryBudget, SharesLimitAmongReservations) {
  const MemoryBudget budget(100);
  auto first = budget.reserve(60, "a");
  ASSERT_TRUE(first);
  const auto refused = budget.reserve(41, "in.raw: 41 samples");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(refused.error().message,
            "in.raw: 41 samples would take 41 B, the limit is 100 B, of which 60 B are in use");
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(budget.reserve(40, "b"));
  first->release();
  EXPECT_TRUE(budget.reserve(100, "c"));
  EXPECT_EQ(budget.reserved(), 0U);
  EXPECT_EQ(budget.peak(), 100U);
}

TEST(MemoryBudget, RefusesSumsThatOverflow) {
  const MemoryBudget budget(~std::uint64_t{0} - 1);
  const auto most = budget.reserve(~std::uint64_t{0} - 2, "a");
  ASSERT_TRUE(most);
  EXPECT_FALSE(budget.reserve(~std::uint64_t{0}, "b"));
  EXPECT_FALSE(budget.reserve(2, "c"));
  EXPECT_TRUE(budget.reserve(1, "d"));
}

TEST(MemoryBudget, ReservationsMoveShrinkAndOutliveBudget) {
  std::optional<MemoryBudget> budget(1000);
  auto reserved = budget->reserve(900, "a");
  ASSERT_TRUE(reserved);
  Reservation moved = std::move(*reserved);
  EXPECT_EQ(reserved->bytes(), 0U);
  moved.shrink(300);
  EXPECT_EQ(budget->reserved(), 300U);
  moved.shrink(400);  // never grows
  EXPECT_EQ(budget->reserved(), 300U);
  moved = Reservation();
  EXPECT_EQ(budget->reserved(), 0U);
  auto late = budget->reserve(10, "b");
  ASSERT_TRUE(late);
  budget.reset();
}

TEST(MemoryBudget, PartsShareLimitAndHaveOwnPeak) {
  const MemoryBudget whole(100);
  const MemoryBudget a = whole.part();
  const MemoryBudget b = whole.part();
  const auto of_a = a.reserve(70, "a");
  ASSERT_TRUE(of_a);
  EXPECT_FALSE(b.reserve(31, "b"));
  EXPECT_TRUE(b.reserve(30, "b"));
  EXPECT_EQ(a.peak(), 70U);
  EXPECT_EQ(b.peak(), 30U);
  EXPECT_EQ(whole.peak(), 100U);
  EXPECT_EQ(b.limit(), 100U);
}

TEST(MemoryBudget, HoldsLimitAcrossThreads) {
  const MemoryBudget budget(1000);
  std::atomic<bool> beyond{false};
  std::vector<std::jthread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 2000; ++i) {
        const auto part = budget.reserve(400, "x");
        if (budget.reserved() > 1000) beyond = true;
      }
    });
  }
  threads.clear();
  EXPECT_FALSE(beyond);
  EXPECT_EQ(budget.reserved(), 0U);
  EXPECT_LE(budget.peak(), 1000U);
  EXPECT_GE(budget.peak(), 400U);
}

TEST(AvailableMemory, IsWithinPlausibleRange) {
  EXPECT_GT(available_memory(), std::uint64_t{64} << 20);
  EXPECT_LT(available_memory(), std::uint64_t{1} << 50);
}

TEST(Context, CopiesShareState) {
  const Context context{MemoryBudget(10)};
  const Context copy = context;
  EXPECT_TRUE(context.check());
  copy.cancel();
  ASSERT_FALSE(context.check());
  EXPECT_EQ(context.check().error().code, ErrorCode::cancelled);
  copy.counters().bytes_read += 3;
  EXPECT_EQ(context.counters().bytes_read, 3U);
  EXPECT_FALSE(copy.reserve(11, "x"));
  EXPECT_TRUE(Context{}.check());
}

// A file that is listed beside a frame must not go on after the frame: a plug-in would run until its time limit.
TEST(Context, CancelsContextsBeside) {
  const Context context;
  const Context beside = context.beside();
  const Context further = beside.beside();
  beside.cancel();
  EXPECT_FALSE(context.cancelled());
  EXPECT_TRUE(further.cancelled());
  const Context other = context.beside();
  context.cancel();
  ASSERT_FALSE(other.check());
  EXPECT_EQ(other.check().error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace isoextract

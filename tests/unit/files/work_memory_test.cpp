// Tests where a large array is: in memory, or in a temporary file.
#include "files/work_memory.hpp"

#include <algorithm>
#include <cstdint>

#include <gtest/gtest.h>

namespace isoextract::test {
namespace {

using files::FileUse;
using files::WorkMemory;

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;

FileUse use(bool prefers_file) {
  return {.prefers_file = prefers_file, .least_bytes = 4 * kMiB, .kind_of_data = "numbers"};
}

TEST(WorkMemory, IsInMemoryUnlessAFileIsPreferred) {
  const Context context{MemoryBudget(16 * kMiB)};
  auto memory = WorkMemory::make(8 * kMiB, use(false), context, "a");
  ASSERT_TRUE(memory);
  EXPECT_FALSE(memory->is_in_file());
  EXPECT_EQ(memory->bytes().size(), 8 * kMiB);
  EXPECT_EQ(context.memory().reserved(), 8 * kMiB);
  std::ranges::fill(memory->bytes(), std::byte{7});
  memory->leave(memory->bytes());  // no effect on memory
  EXPECT_EQ(std::ranges::count(memory->bytes(), std::byte{7}), 8 << 20);
  EXPECT_FALSE(memory->lost());

  const auto small = WorkMemory::make(4 * kMiB - 1, use(true), context, "a");
  ASSERT_TRUE(small);
  EXPECT_FALSE(small->is_in_file());
}

TEST(WorkMemory, IsInAFileIfPreferredOrIfMemoryRunsOut) {
  const Context context{MemoryBudget(6 * kMiB)};
  for (const bool preferred : {true, false}) {
    auto memory = WorkMemory::make(preferred ? 4 * kMiB : 8 * kMiB, use(preferred), context, "a");
    ASSERT_TRUE(memory);
    EXPECT_TRUE(memory->is_in_file());
    EXPECT_EQ(context.memory().reserved(), 0U);
    std::ranges::fill(memory->bytes(), std::byte{9});
    memory->leave(memory->bytes());
    EXPECT_EQ(std::ranges::count(memory->bytes(), std::byte{9}), static_cast<std::int64_t>(memory->bytes().size()));
    EXPECT_FALSE(memory->lost());
  }
}

TEST(WorkMemory, RefusesSmallArraysWithoutMemory) {
  const Context context{MemoryBudget(kMiB)};
  const auto small = WorkMemory::make(2 * kMiB, use(true), context, "a: its numbers");
  ASSERT_FALSE(small);
  EXPECT_EQ(small.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(small.error().message, "a: its numbers would take 2 MiB, the limit is 1 MiB");
}

}  // namespace
}  // namespace isoextract::test

#include "base/ranks.hpp"

#include <gtest/gtest.h>

#include "base/packed_values.hpp"
#include "support/thread_ranks.hpp"

namespace isoextract {
namespace {

using test::run_ranks;

TEST(Ranks, GatherByRank) {
  run_ranks([](Ranks& ranks) {
    const auto all = ranks.gather(std::string(static_cast<std::size_t>(ranks.rank()), 'x'));
    ASSERT_TRUE(all);
    EXPECT_EQ(*all, (std::vector<std::string>{"", "x", "xx"}));
    EXPECT_FALSE(ranks.end(nullptr));
  });
}

// Rank 2 fails before the others ask for its bytes: rank 0 gets its error, and no rank waits for another.
TEST(Ranks, ReportTheErrorOfAnotherRank) {
  run_ranks([](Ranks& ranks) {
    const Error error{ErrorCode::output, "no space", {{Remedy::use, Setting::parts, "so"}, "or so"}};
    if (ranks.rank() == 2) {
      EXPECT_FALSE(ranks.end(&error));
      return;
    }
    const auto all = ranks.gather("a");
    ASSERT_FALSE(all);
    EXPECT_EQ(all.error().code, ranks.is_first() ? ErrorCode::output : ErrorCode::cancelled);
    if (ranks.is_first()) {
      EXPECT_EQ(all.error().message, "rank 2: no space");
      EXPECT_EQ(all.error().hint, error.hint);
    }
    EXPECT_FALSE(ranks.gather("b"));  // at once
    const auto other = ranks.end(&all.error());
    ASSERT_TRUE(other);
    EXPECT_EQ(other->code, ErrorCode::output);
  });
}

// A rank that leaves the rest to rank 0 is no error.
TEST(Ranks, LeaveWorkToRankZero) {
  run_ranks([](Ranks& ranks) {
    if (ranks.is_first()) {
      EXPECT_FALSE(ranks.end(nullptr));
      return;
    }
    const Error left = leave_to_first_rank().value();
    EXPECT_FALSE(ranks.end(&left));
  });
}

TEST(PackedValues, ReadAsZerosBeyondTheEnd) {
  const std::string bytes = Packer().put(std::uint64_t{7}).put(std::string("text")).put(1.5).take();
  Unpacker from(bytes);
  EXPECT_EQ(from.get<std::uint64_t>(), 7U);
  EXPECT_EQ(from.get<std::string>(), "text");
  EXPECT_EQ(from.get<double>(), 1.5);
  EXPECT_EQ(from.get<std::uint64_t>(), 0U);
  EXPECT_EQ(from.get<std::string>(), "");
  Unpacker cut(std::string_view(bytes).substr(0, 18));
  EXPECT_EQ(cut.get<std::uint64_t>(), 7U);
  EXPECT_EQ(cut.get<std::string>(), "te");
}

}  // namespace
}  // namespace isoextract

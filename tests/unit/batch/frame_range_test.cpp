#include "batch/frame_range.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "files/frame_pattern.hpp"

namespace isoextract::batch {
namespace {

using Numbers = std::vector<std::int64_t>;

FrameRange parsed_range(const std::string& text) {
  const auto parsed = FrameRange::parse(text);
  EXPECT_TRUE(parsed) << text << ": " << (parsed ? "" : parsed.error().message);
  return parsed.value_or(FrameRange());
}

std::string range_refusal(const std::string& text) {
  const auto parsed = FrameRange::parse(text);
  if (parsed) return "accepted";
  EXPECT_EQ(parsed.error().code, ErrorCode::usage);
  return parsed.error().message;
}

TEST(FrameRange, IncludesBothEnds) {
  EXPECT_EQ(parsed_range("1-5").numbers(), (Numbers{1, 2, 3, 4, 5}));
  EXPECT_EQ(parsed_range("7").numbers(), Numbers{7});
  EXPECT_EQ(parsed_range("7-7x5").numbers(), Numbers{7});
  EXPECT_EQ(parsed_range("1-7x2").numbers(), (Numbers{1, 3, 5, 7}));
  EXPECT_EQ(parsed_range("1-240x2").count(), 120);
  EXPECT_EQ(parsed_range("1-8x3").numbers(), (Numbers{1, 4, 7}));
  EXPECT_EQ(parsed_range("1-8x100").numbers(), Numbers{1});
}

TEST(FrameRange, ParsesNegativeNumbers) {
  EXPECT_EQ(parsed_range("-2-2").numbers(), (Numbers{-2, -1, 0, 1, 2}));
  EXPECT_EQ(parsed_range("-10--5x5").numbers(), (Numbers{-10, -5}));
  EXPECT_EQ(parsed_range("-3").numbers(), Numbers{-3});
  EXPECT_EQ(parsed_range("-5-5x4").numbers(), (Numbers{-5, -1, 3}));
}

TEST(FrameRange, TreatsListsAsSets) {
  EXPECT_EQ(parsed_range("20, 1-3 ,30-40x5").numbers(), (Numbers{1, 2, 3, 20, 30, 35, 40}));
  EXPECT_EQ(parsed_range("1-9x2,2-10x2"), parsed_range("1-10"));
  EXPECT_EQ(parsed_range("5,5,1-5,4-6"), parsed_range("1-6"));
  EXPECT_EQ(parsed_range("1,3"), parsed_range("1-3x2"));
  EXPECT_EQ(parsed_range("1-10x3,1-10x2").numbers(), (Numbers{1, 3, 4, 5, 7, 9, 10}));
}

TEST(FrameRange, ContainsItsNumbers) {
  const FrameRange some = parsed_range("-7--3,0,4-30x5,29,100-1000x7");
  const Numbers numbers = some.numbers();
  EXPECT_EQ(some.count(), numbers.size());
  EXPECT_TRUE(std::is_sorted(numbers.begin(), numbers.end()));
  for (std::int64_t n = -20; n < 1100; ++n) {
    EXPECT_EQ(some.contains(n), std::binary_search(numbers.begin(), numbers.end(), n)) << n;
  }
}

TEST(FrameRange, RefusesInvalidText) {
  EXPECT_EQ(range_refusal("5-1"), "frames 5-1: expected the smaller number first, found 5 before 1");
  EXPECT_EQ(range_refusal("1-5x0"), "frames 1-5x0: expected a step of at least 1, found 0");
  EXPECT_EQ(range_refusal("1-5x-1"), "frames 1-5x-1: expected a step of at least 1, found -1");
  EXPECT_EQ(range_refusal("1-"), "frames: expected A, A-B or A-BxS, found '1-'");
  for (const char* text : {"",
                           ",",
                           "1,",
                           ",1",
                           "1,,2",
                           "a",
                           "1-b",
                           "1-5x",
                           "1-5xx2",
                           "1x5",
                           "1-5 x2",
                           "1-5x2y",
                           "1--",
                           "--5",
                           "+1",
                           "1.5",
                           "1:5",
                           "1..5",
                           "0x10-0x20",
                           "1-5x2.5",
                           "9223372036854775807",
                           "1000000000000000000",
                           "-1000000000000000000",
                           "99999999999999999999-1",
                           " ",
                           "\n"}) {
    EXPECT_NE(range_refusal(text), "accepted") << text;
  }
  EXPECT_EQ(range_refusal("1-\x1b[0m"), "frames: expected A, A-B or A-BxS, found '1-\\x1b[0m'");
  EXPECT_LT(range_refusal(std::string(1 << 20, 'a')).size(), 200U);
  EXPECT_NE(range_refusal(std::string("1\0", 2)), "accepted");
}

TEST(FrameRange, RefusesTooManyFramesBeforeTakingMemory) {
  EXPECT_EQ(parsed_range("1-1000000").count(), kMaxFrames);
  EXPECT_EQ(range_refusal("1-1000001"), "frames 1-1000001: expected at most 1000000 frames, found more");
  EXPECT_NE(range_refusal("1-2000000000"), "accepted");
  EXPECT_NE(range_refusal("-999999999999999999-999999999999999999"), "accepted");
  EXPECT_NE(range_refusal("1-600000,600001-1200000"), "accepted");
  EXPECT_EQ(parsed_range("-999999999999999999-999999999999999999x999999999999999999").numbers(),
            (Numbers{-files::kMaxFrameNumber, 0, files::kMaxFrameNumber}));
}

TEST(FrameRuns, ParseTheirOwnText) {
  for (const char* text : {"1-10,20,30-40x5", "-5-5", "-10--5,-3,7", "1,3", "1-5x2,6,7-27x10"}) {
    const FrameRange one = parsed_range(text);
    EXPECT_EQ(parsed_range(text_of(one.runs())), one) << text;
  }
  EXPECT_EQ(text_of(parsed_range("1-10,20,30-40x5").runs()), "1-10,20,30-40x5");
  EXPECT_EQ(text_of(parsed_range("1,3,10,30,31").runs(), 2), "1,3,...");
  EXPECT_EQ(text_of({}), "");
}

TEST(FrameRuns, CoverTheirNumbers) {
  const Numbers numbers{-9, -7, -5, 0, 1, 2, 4, 9, 10, 20, 30, 31};
  std::vector<FrameRun> runs = runs_of(numbers);
  EXPECT_EQ(text_of(runs), "-9--5x2,0-2,4,9-10,20,30-31");
  Numbers back;
  for (const FrameRun& run : runs) {
    for (std::int64_t n = run.first; n <= run.last; n += run.step) back.push_back(n);
  }
  EXPECT_EQ(back, numbers);
}

}  // namespace
}  // namespace isoextract::batch

#include "render/transfer_function.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "base/srgb.hpp"
#include "support/fields.hpp"

namespace isoextract::render {
namespace {

TransferFunction of(const std::vector<ControlPoint>& points) { return TransferFunction::create(points).value(); }

glm::vec4 at(const TransferFunction& transfer, double value) { return transfer.lookup(transfer.position(value)); }

TEST(TransferFunction, ConvertsOpacitiesToExtinctions) {
  const TransferFunction transfer = of({{-10, {0, 0.5, 1}, 0}, {0, {1, 0.5, 0}, 0.4}, {30, {1, 1, 1}, 1}});
  EXPECT_EQ(at(transfer, -10), glm::vec4(0, 0.5, 1, 0));
  EXPECT_EQ(at(transfer, -99), glm::vec4(0, 0.5, 1, 0));
  EXPECT_NEAR(at(transfer, 0).a, -std::log(0.6), 1e-3);
  EXPECT_NEAR(at(transfer, -5).a, -std::log(0.8), 1e-3);
  EXPECT_NEAR(at(transfer, -5).r, 0.5, 1e-3);
  EXPECT_NEAR(at(transfer, 15).g, 0.75, 1e-3);
  // Opacity 1 is clamped to kMaxOpacity.
  EXPECT_NEAR(at(transfer, 30).a, -std::log(0x1p-24), 1e-5);
  EXPECT_EQ(at(transfer, 1e300), at(transfer, 30));
  EXPECT_EQ(at(transfer, test::kNaN), glm::vec4(0));
  EXPECT_EQ(transfer.table().front(), at(transfer, -10));
  EXPECT_EQ(transfer.table().back(), at(transfer, 30));
}

TEST(TransferFunction, KeepsPrecisionOfLargeValues) {
  const TransferFunction transfer = of({{1e7, {0, 0, 0}, 0}, {1e7 + 1e-3, {1, 1, 1}, 0.5}});
  EXPECT_NEAR(at(transfer, 1e7 + 0.5e-3).r, 0.5, 1e-3);
}

TEST(TransferFunction, MakesStepOfEqualValues) {
  const TransferFunction transfer =
      of({{0, {1, 1, 1}, 0}, {0.5, {1, 1, 1}, 0}, {0.5, {1, 0, 0}, 0.9}, {1, {1, 0, 0}, 0.9}});
  EXPECT_EQ(at(transfer, 0.499).a, 0);
  EXPECT_NEAR(at(transfer, 0.501).a, -std::log(0.1), 1e-6);
}

TEST(TransferFunction, FindsVisiblePositionsInRange) {
  // Entries 0 to 511, and from 900 on, are transparent.
  const TransferFunction transfer =
      of({{0, {}, 0}, {511, {}, 0}, {512, {}, 0.1}, {899, {}, 0.1}, {900, {}, 0}, {1023, {}, 0}});
  EXPECT_FALSE(transfer.is_visible_between(0, 510.9F));
  EXPECT_FALSE(transfer.is_visible_between(-1e6F, 500));
  EXPECT_FALSE(transfer.is_visible_between(511, 511));
  EXPECT_TRUE(transfer.is_visible_between(511.01F, 511.01F));
  EXPECT_TRUE(transfer.is_visible_between(0, 511.5F));
  EXPECT_TRUE(transfer.is_visible_between(-1e30F, 1e30F));
  EXPECT_TRUE(transfer.is_visible_between(700, 710));
  EXPECT_TRUE(transfer.is_visible_between(899.5F, 899.5F));
  EXPECT_FALSE(transfer.is_visible_between(902, 1e6F));
  // Between such extremes rounding may give any position.
  EXPECT_TRUE(transfer.is_visible_between(-1e30F, 500));
  EXPECT_FALSE(TransferFunction().is_visible_between(-1e30F, 1e30F));
  // Must never miss a position that lookup() finds visible.
  for (float low = -3; low < 1030; low += 17.3F) {
    for (float high = low; high < 1030; high += 31.7F) {
      for (float p = low; p <= high; p += 0.9F) {
        if (transfer.lookup(p).a > 0) {
          EXPECT_TRUE(transfer.is_visible_between(low, high)) << low << " " << high;
        }
      }
    }
  }
}

TEST(TransferFunction, RefusesInvalidPoints) {
  const auto refused = [](const std::vector<ControlPoint>& points) {
    const auto made = TransferFunction::create(points);
    return !made && made.error().code == ErrorCode::usage;
  };
  EXPECT_TRUE(refused({}));
  EXPECT_TRUE(refused({{0, {}, 0}}));
  EXPECT_TRUE(refused({{0, {}, 0}, {0, {}, 0}}));
  EXPECT_TRUE(refused({{1, {}, 0}, {0, {}, 0}}));
  EXPECT_TRUE(refused({{0, {}, 0}, {test::kNaN, {}, 0}}));
  EXPECT_TRUE(refused({{0, {}, 0}, {1, {}, 1.1}}));
  EXPECT_TRUE(refused({{0, {}, 0}, {1, {0, -1, 0}, 1}}));
  EXPECT_TRUE(refused({{-1e308, {}, 0}, {1.7e308, {}, 1}}));
}

TEST(TransferFunction, ParsesTextAndNamesBadLine) {
  const auto points =
      parse_transfer_function("# comment\n\n 0 0 0 0 0\n12.5\t1 0.5 0.25 0.75 # end\r\n", "a.tf").value();
  ASSERT_EQ(points.size(), 2U);
  EXPECT_EQ(points[1].value, 12.5);
  EXPECT_EQ(points[1].color, glm::dvec3(1, srgb_to_linear(0.5), srgb_to_linear(0.25)));
  EXPECT_EQ(points[1].opacity, 0.75);
  for (const char* wrong : {"0 0 0 0", "0 0 0 0 0 0", "0 0 0 0 x", "0 2 0 0 0", "nan 0 0 0 0", "0 0 0 0 -0.1"}) {
    const auto refused = parse_transfer_function(std::string("0 0 0 0 0\n") + wrong, "a.tf");
    ASSERT_FALSE(refused) << wrong;
    EXPECT_EQ(refused.error().code, ErrorCode::input);
    EXPECT_TRUE(refused.error().message.starts_with("a.tf: line 2: expected a value")) << refused.error().message;
  }
}

TEST(TransferFunction, BuiltInFunctionsBeginTransparent) {
  for (const auto& word : words_of(BuiltInTransfer{})) {
    const TransferFunction transfer = of(built_in_points(word.value, -3, 5));
    EXPECT_EQ(transfer.min(), -3);
    EXPECT_EQ(transfer.max(), 5);
    EXPECT_EQ(at(transfer, -3).a, 0) << word.word;
    EXPECT_GT(at(transfer, 5).a, 0.05) << word.word;
  }
}

}  // namespace
}  // namespace isoextract::render

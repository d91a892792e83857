#include "base/number_text.hpp"

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(NumberText, HasNoNegativeZero) {
  EXPECT_EQ(number_text(-0.0), "0");
  EXPECT_EQ(number_text(-0.5), "-0.5");
  EXPECT_EQ(number_text(-1e-30), "-1e-30");
  EXPECT_EQ(vector_text({-0.0, 0.0, -1.0}), "0, 0, -1");
  EXPECT_EQ(point_text({-0.0, -0.0, -0.0}), "(0, 0, 0)");
}

TEST(NumberText, RoundsToDigits) {
  EXPECT_EQ(number_text(1.0 / 3), "0.333333");
  EXPECT_EQ(point_text({1.0 / 3, 2, 3}, 9), "(0.333333333, 2, 3)");
}

}  // namespace
}  // namespace isoextract

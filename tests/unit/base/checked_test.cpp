#include "base/checked.hpp"

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(Checked, DetectsOverflowOfProductsAndSums) {
  EXPECT_EQ(checked_product(std::uint32_t{1} << 31, 4U, 2U), std::uint64_t{1} << 34);
  EXPECT_EQ(checked_product(std::uint64_t{1} << 63, std::uint64_t{2}), std::nullopt);
  EXPECT_EQ(checked_product(std::uint64_t{1} << 40, std::uint64_t{1} << 40, std::uint64_t{0}), std::nullopt);
  EXPECT_EQ(checked_sum(~std::uint64_t{0}, std::uint64_t{0}), ~std::uint64_t{0});
  EXPECT_EQ(checked_sum(~std::uint64_t{0}, std::uint64_t{1}), std::nullopt);
}

}  // namespace
}  // namespace isoextract

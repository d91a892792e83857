#include "files/natural_order.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::files {
namespace {

TEST(NaturalOrder, ComparesNumbersByValue) {
  std::vector<std::string> names{"f10", "f2", "f1", "f", "g1", "f2b1", "f2a10", "f2a9", "f010", "F3"};
  std::ranges::sort(names, NaturalLess());
  EXPECT_EQ(names, (std::vector<std::string>{"F3", "f", "f1", "f2", "f2a9", "f2a10", "f2b1", "f010", "f10", "g1"}));
}

TEST(NaturalOrder, ComparesNumbersOfAnyLength) {
  const std::string nines = "f" + std::string(400, '9');
  const std::string larger = "f1" + std::string(400, '0');
  EXPECT_TRUE(NaturalLess()(nines, larger));
  EXPECT_TRUE(NaturalLess()("f" + std::string(400, '0') + "2", "f3"));
  EXPECT_TRUE(NaturalLess()("f0", "f00"));
  EXPECT_TRUE(NaturalLess()("f00a", "f0b"));
}

// Only names with equal bytes compare equal, and the order has no cycles.
TEST(NaturalOrder, IsTotalOrder) {
  const std::vector<std::string> pieces{"", "0", "00", "1", "01", "a", "-", "/", ":", "\xff", std::string(1, '\0')};
  std::vector<std::string> names;
  for (const auto& a : pieces) {
    for (const auto& b : pieces) {
      for (const auto& c : pieces) names.push_back(a + b + c);
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  std::ranges::sort(names, NaturalLess());
  for (std::size_t i = 0; i < names.size(); ++i) {
    for (std::size_t j = 0; j < names.size(); ++j) {
      ASSERT_EQ(natural_order(names[i], names[j]), i <=> j)
          << testing::PrintToString(names[i]) << " and " << testing::PrintToString(names[j]);
    }
  }
}

}  // namespace
}  // namespace isoextract::files

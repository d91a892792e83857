// The conservative rule passes all stiff cases; the printed rule does not.
#include "simulate/water_stability.hpp"

#include <algorithm>

#include <gtest/gtest.h>

namespace isoextract::simulate {
namespace {

TEST(WaterStability, PassesConservativeRuleAndFailsPrintedRule) {
  const auto rows = run_water_stability(simulate::kStabilitySteps, Context());
  ASSERT_TRUE(rows);
  ASSERT_EQ(rows->size(), 24U);
  std::size_t below_zero = 0;
  for (const WaterStabilityRow& row : *rows) {
    EXPECT_EQ(row.conservative.failures(row.energy_allowed), std::vector<std::string>{})
        << row.name << ", friction " << row.friction << ", flow-div " << row.flow_div;
    EXPECT_EQ(row.conservative.steps, kStabilitySteps);
    below_zero += row.printed.least_depth < -0.01 ? 1 : 0;
  }
  EXPECT_GT(below_zero, 12U);
}

TEST(WaterStability, DescribesFailures) {
  WaterFindings found;
  EXPECT_TRUE(found.failures(1).empty());
  found.drift = 1e-11;
  found.least_depth = -0.5;
  found.most_energy = 2;
  EXPECT_EQ(found.failures(1), (std::vector<std::string>{"volume error 1.0e-11 (limit 1.0e-12)", "minimum depth -0.5",
                                                         "energy 2.0e+00 above the limit"}));
  found = {};
  found.finite = false;
  found.steps = 7;
  EXPECT_EQ(found.failures(1), std::vector<std::string>{"not finite after 7 steps"});
}

}  // namespace
}  // namespace isoextract::simulate

// Runs both rules of the water automaton in stiff cases: friction 0 and 1, flow divisors 1 to 4, steep land, and water
// that advances over dry land.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "simulate/water.hpp"

namespace isoextract::simulate {

inline constexpr std::uint64_t kStabilitySteps = 10'000;
inline constexpr double kDriftAllowed = 1e-12;

struct WaterFindings {
  double drift = 0;  // WaterBalance::drift() at the end, or when a number was not finite
  // Extremes over all cells, taken after each of the first 1,000 steps and then after every 50th step.
  double least_depth = 0;
  double most_energy = 0;   // absolute value
  std::uint64_t steps = 0;  // steps done: fewer than requested if a number was not finite
  bool finite = true;

  // Returns the failures in words, none if all is well. Limits: kDriftAllowed, no negative depth, and `energy_allowed`.
  [[nodiscard]] std::vector<std::string> failures(double energy_allowed) const;
};

struct WaterStabilityRow {
  std::string name;  // name of the scene
  double friction = 0;
  double flow_div = 1;
  // Limit of the absolute energy of a cell. The conservative rule guarantees |E| <= Q (1 + (1 - friction) +
  // (1 - friction)^2 + ...), with one term per step, where Q is the largest inflow of a cell in a step. As Q, the limit
  // uses all water that is ever in the scene, which no inflow can exceed.
  double energy_allowed = 0;
  WaterFindings conservative;  // WaterRule::conservative
  WaterFindings printed;       // WaterRule::printed, the rule as the paper's listing has it
};

struct WaterStabilityScene {
  std::string name;
  std::string extreme;  // the extreme property of the scene
};
[[nodiscard]] std::vector<WaterStabilityScene> water_stability_scenes();

// Runs both rules in each scene with friction 0 and 1 and flow divisors 1, 2, 3 and 4, in parallel. Rows are ordered by
// scene, then friction, then divisor. The result does not depend on the number of threads. Fails as
// WaterAutomaton::create() and run() do.
[[nodiscard]] Result<std::vector<WaterStabilityRow>> run_water_stability(std::uint64_t steps, const Context& context);

}  // namespace isoextract::simulate

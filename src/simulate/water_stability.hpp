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
  // Extremes over all cells, after each of the first 1,000 steps and every 50th from there on.
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
  // The conservative rule guarantees |E| <= Q (1 + (1 - friction) + (1 - friction)^2 + ...), one term a step. Q is the
  // largest inflow of a cell in a step; the limit takes all water there ever is for Q.
  double energy_allowed = 0;
  WaterFindings conservative;
  WaterFindings printed;
};

struct WaterStabilityScene {
  std::string name;
  std::string extreme;  // the extreme property of the scene
};
[[nodiscard]] std::vector<WaterStabilityScene> water_stability_scenes();

// Runs all scenes with friction 0 and 1 and the divisors 1, 2, 3 and 4, in parallel; rows are in that order of nesting.
// The result does not depend on the number of threads. Fails as WaterAutomaton::create() and run() do.
[[nodiscard]] Result<std::vector<WaterStabilityRow>> run_water_stability(std::uint64_t steps, const Context& context);

}  // namespace isoextract::simulate

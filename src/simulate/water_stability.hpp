// What the two rules of the water's automaton do where they are stiff: friction 0 and 1, flow divisors 1 to 4, steep
// land, and water that advances over dry land.
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
  double drift = 0;  // WaterBalance::drift() at the end, or where a number became infinite
  // Of any cell, after each of the first 1000 steps and every 50th from there on.
  double least_depth = 0;
  double most_energy = 0;   // likewise, by its absolute value
  std::uint64_t steps = 0;  // done: fewer than asked for where a number became infinite
  bool finite = true;

  // What is wrong with it, in words; empty where all is well.
  [[nodiscard]] std::vector<std::string> failures(double energy_allowed) const;
};

struct WaterStabilityRow {
  std::string name;  // of the land and the water
  double friction = 0;
  double flow_div = 1;
  // |E| <= Q (1 + (1 - friction) + (1 - friction)^2 + ...) under the conservative rule, one term a step, where Q is the
  // most that flows into a cell in a step: no more than all the water there is.
  double energy_allowed = 0;
  WaterFindings conservative;
  WaterFindings printed;
};

struct WaterStabilityScene {
  std::string name;
  std::string extreme;  // what is extreme about it
};
[[nodiscard]] std::vector<WaterStabilityScene> water_stability_scenes();

// All scenes with friction 0 and 1 and the divisors 1, 2, 3 and 4. In parallel; the same numbers for any number of
// threads.
[[nodiscard]] Result<std::vector<WaterStabilityRow>> run_water_stability(std::uint64_t steps, const Context& context);

}  // namespace isoextract::simulate

#include "simulate/water_stability.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"

namespace isoextract::simulate {
namespace {

constexpr int kSide = 10;                 // cells along x and y
constexpr std::uint64_t kLookEvery = 50;  // steps between checks after the first 1,000

struct StabilityGrid {
  std::vector<double> terrain;
  std::vector<double> depth;
  std::vector<WaterTap> sources;
  std::vector<WaterTap> drains;
  double total_water(std::uint64_t steps) const {
    double sum = 0;
    for (const double value : depth) sum += value;
    for (const WaterTap& source : sources) sum += source.rate * static_cast<double>(steps);
    return sum;
  }
};

enum class Land { steep, dam, brook };

struct NamedLand {
  Land land;
  const char* name;
  const char* extreme;
};
constexpr std::array<NamedLand, 3> kLands{
    {{Land::steep, "steep", "Stairs of 50 cells each, with water on all of them."},
     {Land::dam, "dry front", "A column of water breaks over dry, even land."},
     {Land::brook, "brook", "A source on a slope and a drain below it, over land that was dry."}}};

StabilityGrid grid_of(Land land) {
  StabilityGrid grid;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      double height = 0;
      double depth = 0;
      switch (land) {
        case Land::steep:
          height = 50.0 * (kSide - 1 - x) + 0.5 * (y % 3);
          depth = 1 + 0.25 * x;
          break;
        case Land::dam: depth = x < 3 ? 8 : 0; break;
        case Land::brook: height = 0.75 * x + 0.3 * std::abs(y - kSide / 2); break;
      }
      grid.terrain.push_back(height);
      grid.depth.push_back(depth);
    }
  }
  if (land == Land::brook) {
    grid.sources.push_back({{kSide - 2, kSide / 2}, 0.5});
    grid.drains.push_back({{1, kSide / 2}, 0.4});
  }
  return grid;
}

Result<WaterFindings> run_rule(const StabilityGrid& grid, WaterOptions options, std::uint64_t steps,
                               const Context& context) {
  options.sources = grid.sources;
  options.drains = grid.drains;
  auto automaton = TRY(WaterAutomaton::create({kSide, kSide}, grid.terrain, grid.depth, std::move(options), context));
  WaterFindings found;
  while (found.steps < steps && found.finite) {
    const std::uint64_t some = std::min(found.steps < 1000 ? 1 : kLookEvery, steps - found.steps);
    TRY(automaton.run(some));
    const WaterExtremes now = automaton.extremes();
    found.finite = now.finite;
    found.least_depth = std::min(found.least_depth, now.least_depth);
    found.most_energy = std::max(found.most_energy, now.most_energy);
    found.steps += some;
  }
  found.drift = automaton.balance().drift();
  return found;
}

double max_allowed_energy(double flow, double friction, std::uint64_t steps) {
  const auto n = static_cast<double>(steps);
  return flow * (friction > 0 ? (1 - std::pow(1 - friction, n)) / friction : n);
}

}  // namespace

std::vector<std::string> WaterFindings::failures(double energy_allowed) const {
  std::vector<std::string> wrong;
  if (!finite) return {fmt::format("not finite after {} steps", steps)};
  if (!(drift <= kDriftAllowed))
    wrong.push_back(fmt::format("volume error {:.1e} (limit {:.1e})", drift, kDriftAllowed));
  if (!(least_depth >= 0)) wrong.push_back(fmt::format("minimum depth {:.3g}", least_depth));
  if (!(most_energy <= energy_allowed)) wrong.push_back(fmt::format("energy {:.1e} above the limit", most_energy));
  return wrong;
}

std::vector<WaterStabilityScene> water_stability_scenes() {
  std::vector<WaterStabilityScene> scenes;
  for (const NamedLand& land : kLands) scenes.push_back({land.name, land.extreme});
  return scenes;
}

Result<std::vector<WaterStabilityRow>> run_water_stability(std::uint64_t steps, const Context& context) {
  std::vector<WaterStabilityRow> rows;
  std::vector<StabilityGrid> grids;
  for (const NamedLand& land : kLands) {
    for (const double friction : {0.0, 1.0}) {
      for (const double flow_div : {1.0, 2.0, 3.0, 4.0}) {
        grids.push_back(grid_of(land.land));
        WaterStabilityRow row{land.name, friction, flow_div, 0, {}, {}};
        row.energy_allowed = max_allowed_energy(grids.back().total_water(steps), friction, steps);
        rows.push_back(std::move(row));
      }
    }
  }
  std::vector<std::optional<Error>> errors(rows.size());
  for_each_index(rows.size(), [&](std::size_t i) {
    WaterStabilityRow& row = rows[i];
    for (const WaterRule rule : {WaterRule::conservative, WaterRule::printed}) {
      WaterOptions options;
      options.rule = rule;
      options.friction = row.friction;
      options.flow_div = row.flow_div;
      auto found = run_rule(grids[i], std::move(options), steps, context);
      if (!found) {
        errors[i] = std::move(found.error());
        return;
      }
      (rule == WaterRule::printed ? row.printed : row.conservative) = *found;
    }
  });
  for (std::optional<Error>& error : errors) {
    if (error) return tl::unexpected(std::move(*error));
  }
  return rows;
}

}  // namespace isoextract::simulate

#include "extract/detail/net_shells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace isoextract::extract {

void ShellLinks::solve(const std::vector<Shell>& shells, ShellSteps& chosen) const {
  constexpr int kRounds = 16;
  constexpr double kLowest = 0.1;  // steps that are nearly equal for all shells change no volume, and are left out
  constexpr double kMiddle = (2 + kLowest) / 2;
  constexpr double kHalf = (2 - kLowest) / 2;
  const std::size_t count = shells.size();
  std::vector<std::int64_t> diagonal(count, 0);
  for_each_link([&](std::uint32_t a, std::uint32_t b, std::int64_t area) {
    diagonal[a] += area;
    if (b != NetFaces::kNoShell) diagonal[b] += area;
  });
  const auto scaled = [&](std::size_t s, double change) {
    constexpr double kMost = 8;  // no point moves that far; keeps products small
    return diagonal[s] > 0 ? std::clamp(change / (static_cast<double>(diagonal[s]) / kLinkUnits), -kMost, kMost) : 0.0;
  };
  std::vector<double> rest(count);
  std::vector<std::int64_t> way(count);
  std::vector<std::int64_t> steps(count, 0);
  std::vector<std::int64_t> change(count);
  for (std::size_t s = 0; s < count; ++s) {
    rest[s] = -shells[s].gain * from_units(shells[s].excess);
    way[s] = std::llround(scaled(s, rest[s]) / kMiddle * kStepUnits);
  }
  double factor = kHalf / kMiddle;
  for (int round = 0; round < kRounds; ++round) {
    std::ranges::fill(change, 0);
    for_each_link([&](std::uint32_t a, std::uint32_t b, std::int64_t area) {
      const std::int64_t flow = area * (b == NetFaces::kNoShell ? way[a] : way[a] - way[b]);
      change[a] += flow;
      if (b != NetFaces::kNoShell) change[b] -= flow;
    });
    const double next = 1 / (2 * kMiddle / kHalf - factor);
    for (std::size_t s = 0; s < count; ++s) {
      steps[s] += way[s];
      rest[s] -= static_cast<double>(change[s]) / (kLinkUnits * kStepUnits);
      way[s] = std::llround(next * factor * static_cast<double>(way[s]) +
                            2 * next / kHalf * scaled(s, rest[s]) * kStepUnits);
    }
    factor = next;
  }
  for (std::size_t s = 0; s < count; ++s) chosen.set(s, static_cast<double>(steps[s]) / kStepUnits);
}

}  // namespace isoextract::extract

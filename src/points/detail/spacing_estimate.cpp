#include "points/detail/spacing_estimate.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "base/median.hpp"
#include "base/parallel.hpp"
#include "points/detail/symmetric_eigen.hpp"

namespace isoextract::points {
namespace {

constexpr std::size_t kMostMeasured = std::size_t{1} << 12U;
constexpr std::size_t kNeighbors = 48;
constexpr double kMostOffCenter = 0.3;  // distance to the mean of the neighbors, relative to their rms distance
constexpr double kSameDensity = 1.25;   // ratio of two spacings

struct LocalSpacing {
  double spacing = 0;  // 0 if the neighbors have no finite extent
  bool is_centered = false;
};

// Solves m s^3 = c w_1 w_2 w_3 for s by bisection; m is `count`, and `variances` are in descending order.
double solve_spacing(const glm::dvec3& variances, double count, bool is_whole) {
  const double width = std::sqrt(12 * variances[0]);
  double low = width / count;  // w_1 s^2 <= w_1 w_2 w_3
  double high = 2 * width;     // enough for two particles, which have the fewest
  constexpr int kSteps = 60;
  for (int step = 0; step < kSteps; ++step) {
    const double s = (low + high) / 2;
    const glm::dvec3 w = glm::sqrt(12.0 * variances + glm::dvec3(s * s));
    const double c = is_whole ? 1 : 1 + 0.02 * (w[1] / w[0]) + 0.05 * (w[2] / w[0]);
    (c * (w[0] / s) * (w[1] / s) * (w[2] / s) > count ? low : high) = s;
  }
  return (low + high) / 2;
}

// `neighbors` are vectors to the neighbors of a particle, in order of distance.
LocalSpacing spacing_at(std::span<const glm::dvec3> neighbors) {
  if (neighbors.empty()) return {};
  // Relative to the farthest neighbor, so that squares neither overflow nor underflow.
  const double unit = glm::length(neighbors.back());
  if (!(unit > 0) || !std::isfinite(unit)) return {};
  const double count = 1 + static_cast<double>(neighbors.size());
  glm::dvec3 mean(0);
  glm::dmat3 moments(0);
  for (const glm::dvec3& neighbor : neighbors) {
    const glm::dvec3 offset = neighbor / unit;
    mean += offset / count;
    moments += glm::outerProduct(offset, offset) / count;
  }
  const double mean_square = moments[0][0] + moments[1][1] + moments[2][2];
  const glm::dvec3 variances = symmetric_eigen(moments - glm::outerProduct(mean, mean)).values;
  return {unit * solve_spacing(glm::max(variances, glm::dvec3(0)), count, neighbors.size() < kNeighbors),
          glm::dot(mean, mean) < kMostOffCenter * kMostOffCenter * mean_square};
}

}  // namespace

Result<std::optional<double>> estimate_spacing(const NearbyPositions& positions, const Context& context) {
  const std::size_t measured = std::min(positions.size(), kMostMeasured);
  std::vector<LocalSpacing> local(measured);
  for_each_range(measured, 64, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    std::vector<glm::dvec3> neighbors;
    for (std::size_t n = begin; n != end; ++n) {
      const std::size_t particle = n * positions.size() / measured;
      if (!positions.has_position(particle)) continue;
      positions.find(particle, kNeighbors, neighbors);
      local[n] = spacing_at(neighbors);
    }
  });
  TRY(context.check());
  std::erase_if(local, [](const LocalSpacing& l) { return !(l.spacing > 0) || !std::isfinite(l.spacing); });
  if (local.empty()) return std::optional<double>();
  const auto centered = static_cast<std::size_t>(std::ranges::count_if(local, &LocalSpacing::is_centered));
  const bool has_interior = centered > 0 && 20 * centered >= local.size();
  std::vector<double> spacings;
  for (const LocalSpacing& l : local) {
    if (l.is_centered || !has_interior) spacings.push_back(l.spacing);
  }
  std::ranges::sort(spacings);
  const double dense = kSameDensity * spacings[spacings.size() / 10];
  spacings.erase(std::ranges::upper_bound(spacings, dense), spacings.end());
  return std::optional(median(std::move(spacings)));
}

}  // namespace isoextract::points

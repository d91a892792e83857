#include "points/particle_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/median.hpp"
#include "base/parallel.hpp"
#include "points/detail/nearby_positions.hpp"
#include "points/detail/spacing_estimate.hpp"

namespace isoextract::points {
namespace {

constexpr std::size_t kMostAsked = std::size_t{1} << 16U;

struct BoundsPart {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};
  std::uint64_t not_finite = 0;
  std::size_t first_broken = std::numeric_limits<std::size_t>::max();
};

Result<std::optional<double>> radius_from(const NearbyPositions& positions, const Context& context) {
  auto spacing = TRY(estimate_spacing(positions, context));
  if (spacing) *spacing /= 2;
  return spacing;
}

}  // namespace

ParticleBounds measure_bounds(std::span<const glm::dvec3> positions) {
  const BoundsPart all = reduce_ranges(
      positions.size(), 4096, BoundsPart{},
      [&](std::size_t begin, std::size_t end, BoundsPart part) {
        for (std::size_t i = begin; i != end; ++i) {
          if (!is_finite(positions[i])) {
            ++part.not_finite;
            part.first_broken = std::min(part.first_broken, i);
            continue;
          }
          part.min = glm::min(part.min, positions[i]);
          part.max = glm::max(part.max, positions[i]);
        }
        return part;
      },
      [](const BoundsPart& a, const BoundsPart& b) {
        return BoundsPart{glm::min(a.min, b.min), glm::max(a.max, b.max), a.not_finite + b.not_finite,
                          std::min(a.first_broken, b.first_broken)};
      });
  ParticleBounds bounds;
  bounds.not_finite = all.not_finite;
  bounds.finite = positions.size() - all.not_finite;
  if (bounds.finite != 0) bounds.box = {all.min, all.max};
  if (bounds.not_finite != 0) bounds.first_broken = all.first_broken;
  return bounds;
}

Result<ParticleStatistics> measure_statistics(const ParticleSet& particles, const Context& context) {
  const auto positions = TRY(NearbyPositions::make(particles, context));
  ParticleStatistics statistics;
  statistics.bounds = measure_bounds(particles.positions.span());
  statistics.suggested_radius = TRY(radius_from(positions, context));
  const std::size_t asked = std::min(positions.size(), kMostAsked);
  auto memory = TRY(context.reserve(2 * asked * sizeof(double), particles.label + ": distances of particles"));
  std::vector<double> distances(asked);
  for_each_range(asked, 256, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    std::vector<glm::dvec3> nearest;
    for (std::size_t n = begin; n != end; ++n) {
      const std::size_t particle = n * positions.size() / asked;
      nearest.clear();
      if (positions.has_position(particle)) positions.find(particle, 1, nearest);
      distances[n] = nearest.empty() ? std::numeric_limits<double>::infinity() : glm::length(nearest.front());
    }
  });
  TRY(context.check());
  std::erase_if(distances, [](double d) { return !std::isfinite(d); });
  if (distances.empty()) return statistics;
  const auto [least, most] = std::ranges::minmax(distances);
  statistics.neighbors = NeighborDistances{distances.size(), least, median(std::move(distances)), most};
  return statistics;
}

Result<std::optional<double>> suggest_radius(const ParticleSet& particles, const Context& context) {
  const auto positions = TRY(NearbyPositions::make(particles, context));
  return radius_from(positions, context);
}

}  // namespace isoextract::points

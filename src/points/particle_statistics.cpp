#include "points/particle_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/median.hpp"
#include "base/parallel.hpp"
#include "points/detail/nearest_tree.hpp"
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

Result<NearestTree> make_tree(const ParticleSet& particles, const Context& context) {
  if (particles.size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input, fmt::format("{}: expected at most {} particles, found {}", particles.label,
                                              std::numeric_limits<std::uint32_t>::max(), particles.size()));
  }
  context.progress().begin("measuring distances", 0);
  return NearestTree::make(particles.positions.span(), context, particles.label);
}

Result<std::optional<double>> radius_from(const NearestTree& tree, std::span<const glm::dvec3> positions,
                                          const Context& context) {
  auto spacing = TRY(estimate_spacing(tree, positions, context));
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
  const std::span<const glm::dvec3> positions = particles.positions.span();
  auto tree = TRY(make_tree(particles, context));
  ParticleStatistics statistics;
  statistics.bounds = measure_bounds(positions);
  statistics.suggested_radius = TRY(radius_from(tree, positions, context));
  const std::size_t asked = std::min(positions.size(), kMostAsked);
  auto memory = TRY(context.reserve(2 * asked * sizeof(double), particles.label + ": distances of particles"));
  std::vector<double> distances(asked);
  for_each_range(asked, 256, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t n = begin; n != end; ++n) {
      const glm::dvec3& p = positions[n * positions.size() / asked];
      distances[n] = is_finite(p) ? std::sqrt(tree.nearest(p, NearestTree::Same::ignored).squared_distance)
                                  : std::numeric_limits<double>::infinity();
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
  const auto tree = TRY(make_tree(particles, context));
  return radius_from(tree, particles.positions.span(), context);
}

}  // namespace isoextract::points

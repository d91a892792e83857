#include "points/neighbor_counts.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "field/samples.hpp"
#include "points/cell_grid.hpp"
#include "points/detail/source_points.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {

Result<std::size_t> add_neighbor_counts(ParticleSet& particles, double radius, double smoothing_length,
                                        const Context& context) {
  const double support = 2 * smoothing_length * radius;
  auto memory = TRY(context.reserve(particles.size() * sizeof(float), particles.label + ": neighbors of particles"));
  Buffer<float> counts(particles.size());
  std::ranges::fill(counts, 0.0F);
  const auto points = TRY(SourcePoints::make(particles, support, context));
  const ParticleBounds bounds = measure_bounds(points.positions());
  const GridFrame frame{bounds.box.min / 2.0 + bounds.box.max / 2.0, points.support()};
  const glm::dvec3 half = frame(bounds.box.max);
  if (!(std::max({half.x, half.y, half.z}) < field::kMaxSparseIndex)) {
    return fail(ErrorCode::input, fmt::format("{}: the particles are too far apart for kernels with a reach of {}",
                                              particles.label, support));
  }
  const auto grid =
      TRY(CellGrid::make(points.positions(), frame, 1, CellGrid::Coinciding::merged, context, particles.label));
  context.progress().begin("counting neighbors", grid.size());
  for_each_range(grid.size(), 512, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t spot = begin; spot != end; ++spot) {
      const glm::dvec3 here = grid.position(spot);
      double count = -1;  // the particle itself
      grid.for_each_spot_run(here - 1.0, here + 1.0, [&](std::size_t first, std::size_t last) {
        for (std::size_t s = first; s != last; ++s) {
          const glm::dvec3 away = grid.position(s) - here;
          count += std::max(0.0, 1 - glm::dot(away, away)) * static_cast<double>(grid.members(s).size());
        }
      });
      for (const std::uint32_t point : grid.members(spot)) {
        if (point < particles.size()) counts[point] = static_cast<float>(count);
      }
    }
    context.progress().advance(end - begin);
  });
  TRY(context.check());
  particles.attributes.push_back({"neighbors", 1, std::move(counts)});
  particles.memory.take(std::move(memory));
  return particles.attributes.size() - 1;
}

}  // namespace isoextract::points

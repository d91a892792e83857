#include "points/detail/spot_density.hpp"

#include <array>
#include <cmath>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "points/detail/spline_sums.hpp"

namespace isoextract::points {
namespace {

// Spots of one cell whose sums are taken together; relative to the cell, in units of the support.
struct Targets {
  static constexpr std::size_t kMost = 64;
  alignas(64) std::array<float, kMost> x{};
  alignas(64) std::array<float, kMost> y{};
  alignas(64) std::array<float, kMost> z{};
  alignas(64) std::array<float, kMost> sums{};
};

void measure_cell(const CellGrid& grid, std::size_t c, double support, float* densities) {
  const int rings = static_cast<int>(std::ceil(support / grid.side()));
  const glm::ivec3 at = grid.cell(c).at;
  const glm::dvec3 corner = glm::dvec3(at) * grid.side();
  const double scale = 1 / support;
  BallBatch sources;
  for (std::size_t first = grid.cell(c).first; first < grid.cell_end(c); first += Targets::kMost) {
    const std::size_t count = std::min(Targets::kMost, grid.cell_end(c) - first);
    Targets targets;
    for (std::size_t t = 0; t < count; ++t) {
      const glm::vec3 p((grid.place(first + t) - corner) * scale);
      targets.x[t] = p.x;
      targets.y[t] = p.y;
      targets.z[t] = p.z;
    }
    const auto add = [&] {
      add_at_targets(sources, targets.x.data(), targets.y.data(), targets.z.data(), (count + 7) / 8 * 8,
                     targets.sums.data());
      sources.size = 0;
    };
    grid.for_each_run(at - rings, at + rings, [&](std::size_t from, std::size_t to) {
      for (std::size_t s = grid.cell(from).first; s < grid.cell_end(to - 1); ++s) {
        const glm::vec3 p((grid.place(s) - corner) * scale);
        sources.x[sources.size] = p.x;
        sources.y[sources.size] = p.y;
        sources.z[sources.size] = p.z;
        sources.weight[sources.size] = static_cast<float>(grid.members(s).size());
        if (++sources.size == kBatch) add();
      }
    });
    add();
    for (std::size_t t = 0; t < count; ++t) densities[first + t] = targets.sums[t];
  }
}

}  // namespace

Result<std::shared_ptr<ReservedBuffer<float>>> measure_density(const CellGrid& grid, double support,
                                                               const Context& context, const std::string& label) {
  auto made = make_reserved_buffer<float>(grid.size(), context,
                                          fmt::format("{}: the densities of {} particles", label, grid.size()));
  if (!made) return made;
  context.progress().begin("measuring densities", grid.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, grid.cell_count(), 32), [&](const auto& range) {
    if (context.cancelled()) return;
    for (std::size_t c = range.begin(); c != range.end(); ++c) measure_cell(grid, c, support, (*made)->values.data());
    context.progress().advance(grid.cell_end(range.end() - 1) - grid.cell(range.begin()).first);
  });
  if (auto go_on = context.check(); !go_on) return tl::unexpected(go_on.error());
  return made;
}

}  // namespace isoextract::points

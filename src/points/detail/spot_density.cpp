#include "points/detail/spot_density.hpp"

#include <array>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "points/detail/near_spots.hpp"

namespace isoextract::points {
namespace {

void measure_cell(const CellGrid& grid, std::size_t c, double support, float* densities) {
  alignas(64) std::array<float, CellTargets::kMost> sums;
  for_each_near_batch(
      grid, c, support, [&](const CellTargets&) { sums.fill(0); },
      [&](const CellTargets& targets, const BallBatch& batch) {
        add_at_targets(batch, targets.x.data(), targets.y.data(), targets.z.data(), targets.padded, sums.data());
      },
      [&](const CellTargets& targets) { std::copy_n(sums.data(), targets.size, densities + targets.first); });
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
  TRY(context.check());
  return made;
}

}  // namespace isoextract::points

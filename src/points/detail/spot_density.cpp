#include "points/detail/spot_density.hpp"

#include <array>

#include <fmt/format.h>

#include "base/parallel.hpp"
#include "points/detail/neighbor_batches.hpp"

namespace isoextract::points {
namespace {

void measure_cell(const CellGrid& grid, std::size_t c, double support, float* densities) {
  alignas(64) std::array<float, CellTargets::kMost> sums;
  for_each_neighbor_batch(
      grid, c, support, [&](const CellTargets&) { sums.fill(0); },
      [&](const CellTargets& targets, const BallBatch& batch) {
        add_at_targets(batch, targets.x.data(), targets.y.data(), targets.z.data(), targets.padded, sums.data());
      },
      [&](const CellTargets& targets) { std::copy_n(sums.data(), targets.size, densities + targets.first); });
}

}  // namespace

Result<std::shared_ptr<ReservedBuffer<float>>> compute_spot_densities(const CellGrid& grid, double support,
                                                                      const Context& context,
                                                                      const std::string& label) {
  auto made = make_reserved_buffer<float>(grid.size(), context,
                                          fmt::format("{}: the densities of {} particles", label, grid.size()));
  if (!made) return made;
  context.progress().begin("measuring densities", grid.size());
  for_each_range(grid.cell_count(), 32, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (std::size_t c = begin; c != end; ++c) measure_cell(grid, c, support, (*made)->values.data());
    context.progress().advance(grid.cell_end(end - 1) - grid.cell(begin).first);
  });
  TRY(context.check());
  return made;
}

}  // namespace isoextract::points

#include "points/detail/neighbor_batches.hpp"

#include <atomic>

#include "base/parallel.hpp"

namespace isoextract::points {

std::uint64_t count_candidate_pairs(const CellGrid& grid, double radius, std::uint64_t most) {
  const int rings = static_cast<int>(std::ceil(radius / grid.side()));
  std::atomic<std::uint64_t> pairs{0};
  for_each_range(grid.cell_count(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t c = begin; c != end; ++c) {
      if (pairs.load(std::memory_order_relaxed) > most) return;
      const glm::ivec3 at = grid.cell(c).at;
      std::uint64_t near = 0;
      grid.for_each_run(at - rings, at + rings, [&](std::size_t from, std::size_t to) {
        near += grid.cell_end(to - 1) - grid.cell(from).first;
      });
      pairs.fetch_add(near * (grid.cell_end(c) - grid.cell(c).first), std::memory_order_relaxed);
    }
  });
  return pairs.load(std::memory_order_relaxed);
}

}  // namespace isoextract::points

// Collects the spots of a cell and all spots near them, in the layout of the vectorized sums.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include <glm/glm.hpp>

#include "points/cell_grid.hpp"
#include "points/detail/spline_sums.hpp"

namespace isoextract::points {

// Up to 64 spots of one cell, relative to the cell's corner, in units of the radius. Padded to a multiple of 8.
struct CellTargets {
  static constexpr std::size_t kMost = Moments::kTargets;
  alignas(64) std::array<float, kMost> x{};
  alignas(64) std::array<float, kMost> y{};
  alignas(64) std::array<float, kMost> z{};
  std::size_t first = 0;   // index of the first spot
  std::size_t size = 0;    // number of spots
  std::size_t padded = 0;  // size rounded up to a multiple of 8
};

// Counts the pairs that for_each_neighbor_batch() visits (a spot with each spot near it, itself included), a measure of
// run time. Stops soon after `most`. Up to `most`, the result is the same for any number of threads.
[[nodiscard]] std::uint64_t count_candidate_pairs(const CellGrid& grid, double radius, std::uint64_t most);

// Visits the spots of cell c, 64 at a time: calls begin(targets), then add(targets, batch) for each batch of source
// spots, then end(targets). The batches have every spot within `radius` of a target and some farther ones; the weight
// of a spot is its number of members. The order depends on the grid alone.
template <class Begin, class Add, class End>
void for_each_neighbor_batch(const CellGrid& grid, std::size_t c, double radius, const Begin& begin, const Add& add,
                             const End& end) {
  const int rings = static_cast<int>(std::ceil(radius / grid.side()));
  const glm::ivec3 at = grid.cell(c).at;
  const glm::dvec3 corner = glm::dvec3(at) * grid.side();
  const double scale = 1 / radius;
  BallBatch batch;
  for (std::size_t first = grid.cell(c).first; first < grid.cell_end(c); first += CellTargets::kMost) {
    CellTargets targets;
    targets.first = first;
    targets.size = std::min(CellTargets::kMost, grid.cell_end(c) - first);
    targets.padded = (targets.size + 7) / 8 * 8;
    for (std::size_t t = 0; t < targets.size; ++t) {
      const glm::vec3 p((grid.position(first + t) - corner) * scale);
      targets.x[t] = p.x;
      targets.y[t] = p.y;
      targets.z[t] = p.z;
    }
    begin(targets);
    grid.for_each_run(at - rings, at + rings, [&](std::size_t from, std::size_t to) {
      const std::size_t last = grid.cell_end(to - 1);
      for (std::size_t s = grid.cell(from).first; s < last;) {
        const std::size_t count = std::min(last - s, kBatch - batch.size);
        float* const x = batch.x.data() + batch.size;
        float* const y = batch.y.data() + batch.size;
        float* const z = batch.z.data() + batch.size;
        float* const weight = batch.weight.data() + batch.size;
        for (std::size_t n = 0; n < count; ++n) {
          const glm::vec3 p((grid.position(s + n) - corner) * scale);
          x[n] = p.x;
          y[n] = p.y;
          z[n] = p.z;
          weight[n] = static_cast<float>(grid.members(s + n).size());
        }
        batch.size += count;
        s += count;
        if (batch.size == kBatch) {
          add(targets, batch);
          batch.size = 0;
        }
      }
    });
    add(targets, batch);
    batch.size = 0;
    end(targets);
  }
}

}  // namespace isoextract::points

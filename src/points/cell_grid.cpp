#include "points/cell_grid.hpp"

#include <limits>

#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include "base/finite.hpp"
#include "base/parallel.hpp"
#include "base/reserved_buffer.hpp"

namespace isoextract::points {
namespace {

// A point and its cell, packed so that keys compare by (x, y, z, index).
struct CellKey {
  std::uint64_t xy;
  std::uint64_t z_index;

  friend bool operator<(const CellKey& a, const CellKey& b) {
    return a.xy != b.xy ? a.xy < b.xy : a.z_index < b.z_index;
  }
};

constexpr std::uint64_t kNoCell = std::numeric_limits<std::uint64_t>::max();  // key part of a skipped point; sorts last
constexpr std::uint32_t kSignBit = 0x80000000U;

std::uint64_t ordered(int v) { return static_cast<std::uint32_t>(v) ^ kSignBit; }
int unordered(std::uint64_t v) { return static_cast<int>(static_cast<std::uint32_t>(v) ^ kSignBit); }

CellKey key_of(const glm::ivec3& cell, std::uint32_t index) {
  return {ordered(cell.x) << 32 | ordered(cell.y), ordered(cell.z) << 32 | index};
}
glm::ivec3 cell_of(const CellKey& key) {
  return {unordered(key.xy >> 32), unordered(key.xy & 0xFFFFFFFFU), unordered(key.z_index >> 32)};
}
bool same_cell(const CellKey& a, const CellKey& b) { return a.xy == b.xy && a.z_index >> 32 == b.z_index >> 32; }

// Most points in a cell without sorting coincident points together; the header states the number.
constexpr std::size_t kMaxUnsortedCell = 32;

bool placed_before(const glm::dvec3& a, const glm::dvec3& b) {
  if (a.x != b.x) return a.x < b.x;
  return a.y != b.y ? a.y < b.y : a.z < b.z;
}

}  // namespace

Result<CellGrid> CellGrid::make(std::span<const glm::dvec3> points, const GridFrame& frame, double side,
                                Coinciding coinciding, const Context& context, const std::string& label) {
  const auto what = [&] { return fmt::format("{}: sorting {} particles", label, points.size()); };
  auto made = TRY(make_reserved_buffer<CellKey>(points.size(), context, what()));
  Buffer<CellKey>& keys = made->values;
  CellGrid grid;
  grid.side_ = side;
  context.progress().begin("sorting particles", 0);
  for_each_range(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) {
      keys[i] = is_finite(points[i]) ? key_of(grid.cell_at(frame(points[i])), static_cast<std::uint32_t>(i))
                                     : CellKey{kNoCell, kNoCell};
    }
  });
  tbb::parallel_sort(keys.begin(), keys.end());
  TRY(context.check());
  const auto count =
      static_cast<std::size_t>(std::lower_bound(keys.begin(), keys.end(), CellKey{kNoCell, kNoCell}) - keys.begin());

  std::size_t cells = 0;
  std::size_t columns = 0;
  for (std::size_t k = 0; k < count; ++k) {
    cells += static_cast<std::size_t>(k == 0 || !same_cell(keys[k], keys[k - 1]));
    columns += static_cast<std::size_t>(k == 0 || keys[k].xy != keys[k - 1].xy);
  }
  grid.memory_ = TRY(context.reserve(
      count * sizeof(std::uint32_t) + (cells + 1) * sizeof(Cell) + (columns + 1) * sizeof(Column), what()));
  grid.order_ = Buffer<std::uint32_t>(count);
  grid.cells_ = Buffer<Cell>(cells + 1);
  grid.columns_ = Buffer<Column>(columns + 1);
  for_each_range(count, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k != end; ++k)
      grid.order_[k] = static_cast<std::uint32_t>(keys[k].z_index & 0xFFFFFFFFU);
  });
  for (std::size_t k = 0; k < count; ++k) {
    if (k != 0 && same_cell(keys[k], keys[k - 1])) continue;
    if (k == 0 || keys[k].xy != keys[k - 1].xy) {
      const glm::ivec3 at = cell_of(keys[k]);
      grid.columns_[grid.column_count_++] = {at.x, at.y, static_cast<std::uint32_t>(grid.cell_count_)};
    }
    grid.cells_[grid.cell_count_++] = {cell_of(keys[k]), static_cast<std::uint32_t>(k)};
  }
  constexpr int kBeyond = std::numeric_limits<int>::max();
  grid.columns_[columns] = {kBeyond, kBeyond, static_cast<std::uint32_t>(cells)};
  grid.cells_[cells] = {glm::ivec3(kBeyond), static_cast<std::uint32_t>(count)};

  made.reset();

  // Compares the original coordinates: grid coordinates are rounded.
  const auto same_spot = [&](std::size_t k, std::size_t first) {
    return k != first && coinciding == Coinciding::merged && points[grid.order_[k]] == points[grid.order_[k - 1]];
  };
  auto places_memory = TRY(context.reserve(count * sizeof(glm::dvec3), what()));
  grid.positions_ = Buffer<glm::dvec3>(count);
  const auto merged = reduce_ranges(
      cells, 256, std::size_t{0},
      [&](std::size_t begin, std::size_t end, std::size_t sum) {
        for (std::size_t c = begin; c != end; ++c) {
          const std::size_t first = grid.cells_[c].first;
          const std::size_t last = grid.cells_[c + 1].first;
          if (coinciding == Coinciding::merged && last - first > kMaxUnsortedCell) {
            tbb::parallel_sort(grid.order_.begin() + first, grid.order_.begin() + last,
                               [&](std::uint32_t a, std::uint32_t b) {
                                 const glm::dvec3& p = points[a];
                                 const glm::dvec3& q = points[b];
                                 return p == q ? a < b : placed_before(p, q);
                               });
          }
          for (std::size_t k = first; k != last; ++k) {
            grid.positions_[k] = frame(points[grid.order_[k]]);
            sum += static_cast<std::size_t>(same_spot(k, first));
          }
        }
        return sum;
      },
      [](std::size_t a, std::size_t b) { return a + b; });
  grid.spots_ = count - merged;
  grid.memory_.take(std::move(places_memory));
  if (merged == 0) return grid;

  // Merges points into spots, in place.
  auto firsts_memory = TRY(context.reserve((grid.spots_ + 1) * sizeof(std::uint32_t), what()));
  grid.firsts_ = Buffer<std::uint32_t>(grid.spots_ + 1);
  grid.memory_.take(std::move(firsts_memory));
  std::size_t spot = 0;
  for (std::size_t c = 0; c < cells; ++c) {
    const std::size_t first = grid.cells_[c].first;
    const std::size_t last = grid.cells_[c + 1].first;
    grid.cells_[c].first = static_cast<std::uint32_t>(spot);
    for (std::size_t k = first; k != last; ++k) {
      if (same_spot(k, first)) continue;
      grid.positions_[spot] = grid.positions_[k];
      grid.firsts_[spot++] = static_cast<std::uint32_t>(k);
    }
  }
  grid.firsts_[grid.spots_] = static_cast<std::uint32_t>(count);
  grid.cells_[cells].first = static_cast<std::uint32_t>(grid.spots_);
  return grid;
}

}  // namespace isoextract::points

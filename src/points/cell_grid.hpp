// Sorts points into the cells of a uniform grid to find the neighbors of a location. Stores only occupied cells, so
// memory grows with the number of points, however far apart they are.
//
// A spot is a position with its points: one point or, with Coinciding::merged, several coincident ones. In a cell with
// more than 32 points, all points at one position share a spot; in other cells, only points whose indices follow each
// other within the cell. A search visits a million coincident points as one spot; memory and sorting time still grow
// with their number.
//
// The order depends on the points alone: by cell (x, then y, then z), then by index. With Coinciding::merged, cells
// with more than 32 points are sorted by position, then by index.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::points {

// Maps a position p to grid coordinates: (p - origin) / unit.
struct GridFrame {
  glm::dvec3 origin{0.0};
  double unit = 1;

  [[nodiscard]] glm::dvec3 operator()(const glm::dvec3& p) const { return (p - origin) / unit; }
};

class CellGrid {
 public:
  struct Cell {
    glm::ivec3 at;        // the cell covers grid coordinates from at * side to (at + 1) * side
    std::uint32_t first;  // index of the cell's first spot
  };

  // Whether coincident points share a spot.
  enum class Coinciding { merged, apart };

  // Builds the grid; skips non-finite points. Grid coordinates / side must fit into an int and the number of points
  // into 32 bits. Fails as Context::reserve() and Context::check() do; `label` names the points in the message.
  [[nodiscard]] static Result<CellGrid> make(std::span<const glm::dvec3> points, const GridFrame& frame, double side,
                                             Coinciding coinciding, const Context& context, const std::string& label);

  [[nodiscard]] std::size_t size() const { return spots_; }
  [[nodiscard]] double side() const { return side_; }
  // Returns the position of a spot in grid coordinates.
  [[nodiscard]] const glm::dvec3& position(std::size_t spot) const { return positions_[spot]; }
  // Returns the indices of the points that share the spot.
  [[nodiscard]] std::span<const std::uint32_t> members(std::size_t spot) const {
    if (firsts_.size() == 0) return {order_.data() + spot, 1};
    return {order_.data() + firsts_[spot], firsts_[spot + 1] - firsts_[spot]};
  }

  // Cells are sorted by `at`.
  [[nodiscard]] std::size_t cell_count() const { return cell_count_; }
  [[nodiscard]] const Cell& cell(std::size_t c) const { return cells_[c]; }
  // Returns the index after the last spot of a cell.
  [[nodiscard]] std::size_t cell_end(std::size_t c) const { return cells_[c + 1].first; }

  [[nodiscard]] glm::ivec3 cell_at(const glm::dvec3& position) const {
    return glm::ivec3(glm::floor(position / side_));
  }

  // Calls f(first, last) for the occupied cells in the box [low, high]: one call for each run along z, in order. The
  // run has the cells first to last - 1.
  template <class F>
  void for_each_run(const glm::ivec3& low, const glm::ivec3& high, const F& f) const {
    const Column* const end = columns_.data() + column_count_;
    for (const Column* column = lower_column(low.x, low.y); column != end && column->x <= high.x;) {
      if (column->y < low.y || column->y > high.y) {
        column = column->y < low.y ? lower_column(column->x, low.y) : lower_column(column->x + 1, low.y);
        continue;
      }
      const Cell* const begin = cells_.data() + column->first;
      const Cell* const stop = cells_.data() + column[1].first;
      const Cell* const from = std::lower_bound(begin, stop, low.z, [](const Cell& c, int z) { return c.at.z < z; });
      const Cell* to = from;
      while (to != stop && to->at.z <= high.z) ++to;
      if (from != to) f(static_cast<std::size_t>(from - cells_.data()), static_cast<std::size_t>(to - cells_.data()));
      ++column;
    }
  }

  // Calls f(first, last) for all spots first to last - 1 of the cells that intersect the box [low, high], in order.
  template <class F>
  void for_each_spot_run(const glm::dvec3& low, const glm::dvec3& high, const F& f) const {
    for_each_run(cell_at(low), cell_at(high), [&](std::size_t first, std::size_t last) {
      f(std::size_t{cells_[first].first}, std::size_t{cells_[last].first});
    });
  }

 private:
  struct Column {
    int x;
    int y;
    std::uint32_t first;  // index of the column's first cell
  };

  [[nodiscard]] const Column* lower_column(int x, int y) const {
    return std::lower_bound(columns_.data(), columns_.data() + column_count_, std::pair(x, y),
                            [](const Column& c, const std::pair<int, int>& at) { return std::pair(c.x, c.y) < at; });
  }

  double side_ = 1;
  std::size_t spots_ = 0;
  std::size_t cell_count_ = 0;
  std::size_t column_count_ = 0;
  Buffer<glm::dvec3> positions_;
  // Per spot: its first entry in order_; one extra at the end. Empty if each spot has one point.
  Buffer<std::uint32_t> firsts_;
  Buffer<std::uint32_t> order_;
  Buffer<Cell> cells_;      // one extra at the end
  Buffer<Column> columns_;  // one extra at the end
  Reservation memory_;
};

}  // namespace isoextract::points

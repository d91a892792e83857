// The value of most voxels in each cell of a coarser grid. Private to resample.cpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <unordered_map>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/parallel.hpp"
#include "field/sample_value.hpp"

namespace isoextract::field {

// The old voxels in the cells of new samples, along one axis. Where the new grid is coarser, a cell is one new step
// wide and centered at its sample; near the boundary it shrinks symmetrically, down to the boundary sample itself. A
// voxel that is partly within a cell counts by the part that is within. Where the new grid is not coarser, a cell is
// the nearest voxel; on a tie, the lower one. Weights are whole numbers, so that equal weights compare equal.
class AxisCells {
 public:
  struct Cell {
    int first = 0;
    int end = 0;
    int nearest = 0;
  };

  // Both grids start and end at the same positions and have at least two samples.
  AxisCells(int old_count, int new_count)
      : extent_(old_count - 1), steps_(new_count - 1), is_coarser_(new_count < old_count) {}

  [[nodiscard]] Cell of(int i) const {
    const std::int64_t below = i * extent_ / steps_;
    const auto nearest = static_cast<int>(2 * (i * extent_ - below * steps_) > steps_ ? below + 1 : below);
    if (!is_coarser_) return {nearest, nearest + 1, nearest};
    // Voxel j lies from (2j - 1) to (2j + 1), in units of steps_.
    const auto first = static_cast<int>((low(i) + steps_) / (2 * steps_));
    const auto end = static_cast<int>((high(i) + 3 * steps_ - 1) / (2 * steps_));
    return {first, end, nearest};
  }
  [[nodiscard]] std::uint64_t weight(int i, int voxel) const {
    if (!is_coarser_) return 1;
    const std::int64_t from = (2 * std::int64_t{voxel} - 1) * steps_;
    return static_cast<std::uint64_t>(std::min(high(i), from + 2 * steps_) - std::max(low(i), from));
  }

 private:
  // Returns half of a cell's width; all lengths are in parts of 1 / (2 * steps_) of a voxel.
  [[nodiscard]] std::int64_t half(int i) const {
    return std::min(extent_, 2 * std::min(i * extent_, (steps_ - i) * extent_) + steps_);
  }
  [[nodiscard]] std::int64_t low(int i) const { return 2 * i * extent_ - half(i); }
  [[nodiscard]] std::int64_t high(int i) const { return 2 * i * extent_ + half(i); }

  std::int64_t extent_;
  std::int64_t steps_;
  bool is_coarser_;
};

// Sums the weights of each value.
class Votes {
 public:
  void clear() {
    votes_.clear();
    places_.clear();
    last_ = 0;
    nan_ = 0;
  }
  void add(double value, std::uint64_t weight) {
    if (std::isnan(value)) {
      nan_ += weight;
    } else {
      votes_[place(value)].weight += weight;
    }
  }
  [[nodiscard]] std::uint64_t nan_weight() const { return nan_; }

  // Returns the value with the most weight. On a tie, returns the value at the center if it is among the tied ones,
  // else the least number. So NaN wins a tie only at the center.
  [[nodiscard]] double winner(double center) const {
    std::uint64_t most = std::isnan(center) ? nan_ : 0;
    for (const Vote& vote : votes_) most = std::max(most, vote.weight);
    if (nan_ > most || (std::isnan(center) && nan_ == most)) return std::numeric_limits<double>::quiet_NaN();
    double least = std::numeric_limits<double>::infinity();
    for (const Vote& vote : votes_) {
      if (vote.weight != most) continue;
      if (vote.value == center) return center;
      least = std::min(least, vote.value);
    }
    return least;
  }

 private:
  struct Vote {
    double value;
    std::uint64_t weight;
  };
  static constexpr std::size_t kFew = 16;

  std::size_t place(double value) {
    if (last_ < votes_.size() && votes_[last_].value == value) return last_;
    if (votes_.size() <= kFew) {
      last_ = static_cast<std::size_t>(std::ranges::find(votes_, value, &Vote::value) - votes_.begin());
    } else {
      if (places_.empty()) {
        for (std::size_t i = 0; i < votes_.size(); ++i) places_.emplace(votes_[i].value, i);
      }
      last_ = places_.try_emplace(value, votes_.size()).first->second;
    }
    if (last_ == votes_.size()) votes_.push_back({value, 0});
    return last_;
  }

  std::vector<Vote> votes_;
  std::unordered_map<double, std::size_t> places_;  // once there are more than kFew
  std::size_t last_ = 0;
  std::uint64_t nan_ = 0;
};

// Fills a grid of `dims` samples with the value of most voxels in each cell. read(y, z, out) writes an old row;
// leave(first, end) follows when old planes were read. With `spreads_nan`, a cell with a NaN in it becomes NaN.
template <class Value, class ReadRow, class Leave>
void fill_majority(const ReadRow& read, const Leave& leave, const glm::ivec3& old_dims, const glm::ivec3& dims,
                   bool spreads_nan, Value* values, const Context& context) {
  const AxisCells along_x(old_dims.x, dims.x);
  const AxisCells along_y(old_dims.y, dims.y);
  const AxisCells along_z(old_dims.z, dims.z);
  const auto width = static_cast<std::size_t>(old_dims.x);
  context.progress().begin("resampling", static_cast<std::uint64_t>(dims.z));
  for_each_index(dims.z, [&](int k) {
    if (context.cancelled()) return;
    const AxisCells::Cell z = along_z.of(k);
    std::vector<double> rows;  // of the cells of one new row
    Votes votes;
    Value* out = values + std::int64_t{dims.x} * dims.y * k;
    for (int j = 0; j < dims.y; ++j) {
      const AxisCells::Cell y = along_y.of(j);
      const auto rows_of_plane = static_cast<std::size_t>(y.end - y.first);
      rows.resize(width * rows_of_plane * static_cast<std::size_t>(z.end - z.first));
      const auto row = [&](int at_y, int at_z) {
        return rows.data() + width * (static_cast<std::size_t>(at_y - y.first) +
                                      rows_of_plane * static_cast<std::size_t>(at_z - z.first));
      };
      for (int at_z = z.first; at_z < z.end; ++at_z) {
        for (int at_y = y.first; at_y < y.end; ++at_y) read(at_y, at_z, row(at_y, at_z));
      }
      for (int i = 0; i < dims.x; ++i) {
        const AxisCells::Cell x = along_x.of(i);
        votes.clear();
        for (int at_z = z.first; at_z < z.end; ++at_z) {
          for (int at_y = y.first; at_y < y.end; ++at_y) {
            const double* const from = row(at_y, at_z);
            const std::uint64_t weight = along_z.weight(k, at_z) * along_y.weight(j, at_y);
            for (int at_x = x.first; at_x < x.end; ++at_x) votes.add(from[at_x], weight * along_x.weight(i, at_x));
          }
        }
        const bool is_nan = spreads_nan && votes.nan_weight() > 0;
        *out++ = to_sample<Value>(is_nan ? std::numeric_limits<double>::quiet_NaN()
                                         : votes.winner(row(y.nearest, z.nearest)[x.nearest]));
      }
    }
    leave(z.first, z.end);
    context.progress().advance(1);
  });
}

}  // namespace isoextract::field

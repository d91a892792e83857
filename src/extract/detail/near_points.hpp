// The numbers of the points at the corners of one chunk of a surface net and one step around it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "extract/detail/net_grid.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

// Places of corners in tables of a chunk and one step around it.
struct NearPlaces {
  // The steps between the places of neighbors along the axes.
  static constexpr std::array<int, 3> kSteps{1, 66, 660};
  static constexpr std::size_t kCount = 6600;

  // Returns the place of a corner. `corner`: from the lowest corner of the chunk, -1 to 64 along x, -1 to 8 along y, z.
  [[nodiscard]] static constexpr int of(int x, int y, int z) { return x + 1 + 66 * (y + 1 + 10 * (z + 1)); }
};

// Calls f(place, number) for the points of a chunk and one step around it.
template <class F>
void for_each_near_point(const NetGrid& grid, std::size_t chunk, const F& f) {
  const auto put_rows = [&](int step_y, int step_z) {
    const auto find = [&](int step_x) {
      return grid.find(grid.origins()[chunk] + kVoxelChunk * glm::ivec3(step_x, step_y, step_z));
    };
    const std::array<std::int32_t, 3> chunks{find(-1), find(0), find(1)};
    const auto first = [](int step) { return step < 0 ? 7 : 0; };
    const auto last = [](int step) { return step > 0 ? 0 : 7; };
    for (int z = first(step_z); z <= last(step_z); ++z) {
      for (int y = first(step_y); y <= last(step_y); ++y) {
        const int place = NearPlaces::of(0, y + 8 * step_y, z + 8 * step_z);
        const NetGrid::Row lower = grid.row(chunks[0], y, z);
        if (lower.used >> 63 != 0) f(place - 1, lower.number(63));
        const NetGrid::Row row = grid.row(chunks[1], y, z);
        std::uint32_t k = row.first;
        for_each_bit(row.used, [&](int bit) { f(place + bit, k++); });
        const NetGrid::Row upper = grid.row(chunks[2], y, z);
        if ((upper.used & 1) != 0) f(place + 64, upper.first);
      }
    }
  };
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) put_rows(y, z);
  }
}

class NearPoints {
 public:
  NearPoints(const NetGrid& grid, std::size_t chunk) {
    for_each_near_point(grid, chunk,
                        [&](int place, std::uint32_t k) { numbers_[static_cast<std::size_t>(place)] = k; });
  }

  // Returns the number of the point at a place that has one. The value at another place is undefined.
  [[nodiscard]] std::uint32_t operator[](int place) const { return numbers_[static_cast<std::size_t>(place)]; }

 private:
  std::array<std::uint32_t, NearPlaces::kCount> numbers_;
};

}  // namespace isoextract::extract

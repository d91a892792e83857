// Lists the point numbers of a surface net in tables by corner. A table covers the corners of one chunk and all corners
// one step around the chunk.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "extract/detail/net_grid.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::extract {

// Maps corners to their places in such a table.
struct NearPlaces {
  // The steps between the places of neighbors along the axes.
  static constexpr std::array<int, 3> kSteps{1, 66, 660};
  static constexpr std::size_t kCount = 6600;

  // Returns the place of a corner, counted from the lowest corner of the chunk: x from -1 to 64, y and z from -1 to 8.
  [[nodiscard]] static constexpr int of(int x, int y, int z) { return x + 1 + 66 * (y + 1 + 10 * (z + 1)); }
};

// The points of a chunk and one step around it, in planes across z.
class NearPointPlanes {
 public:
  NearPointPlanes(const NetGrid& grid, std::size_t chunk) : grid_(grid), chunks_(grid.near(chunk)) {}

  // Calls f(place, number) for the points of plane `z`, from -1 to 8. Places are given as if the plane were plane -1.
  template <class F>
  void for_each(int z, const F& f) const {
    for (int y = -1; y <= 8; ++y) {
      const std::int32_t* const chunks = &chunks_[3 * steps_to(y) + 9 * steps_to(z)];
      const int place = NearPlaces::of(0, y, -1);
      const NetGrid::Row lower = grid_.row(chunks[0], y, z);
      if (lower.used >> 63 != 0) f(place - 1, lower.number(63));
      const NetGrid::Row row = grid_.row(chunks[1], y, z);
      std::uint32_t k = row.first;
      for_each_bit(row.used, [&](int bit) { f(place + bit, k++); });
      const NetGrid::Row upper = grid_.row(chunks[2], y, z);
      if ((upper.used & 1) != 0) f(place + 64, upper.first);
    }
  }

 private:
  // Returns the step along y or z to the chunk that has the corner, plus 1: 0, 1 or 2.
  static std::size_t steps_to(int corner) {
    const int steps = (corner >> 3) + 1;
    return static_cast<std::size_t>(steps);
  }

  const NetGrid& grid_;
  const NetGrid::NearChunkNumbers& chunks_;
};

class NearPoints {
 public:
  NearPoints(const NetGrid& grid, std::size_t chunk) {
    const NearPointPlanes planes(grid, chunk);
    for (int z = -1; z <= 8; ++z) {
      const int first = NearPlaces::kSteps[2] * (z + 1);
      planes.for_each(z, [&](int place, std::uint32_t k) {
        const int at = first + place;
        numbers_[static_cast<std::size_t>(at)] = k;
      });
    }
  }

  // Returns the number of the point at a place that has one. Returns 0 at other places.
  [[nodiscard]] std::uint32_t operator[](int place) const { return numbers_[static_cast<std::size_t>(place)]; }

 private:
  std::array<std::uint32_t, NearPlaces::kCount> numbers_{};  // 0 also guards against arrays that the disk lost
};

}  // namespace isoextract::extract

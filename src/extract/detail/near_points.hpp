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

// The points of a chunk and one step around it, in planes across z.
class NearPointPlanes {
 public:
  NearPointPlanes(const NetGrid& grid, std::size_t chunk) : grid_(grid), chunks_(grid.near(chunk)) {}

  // Calls f(place, number) for the points of a plane, from -1 to 8. Places are those of the plane -1.
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
  // Returns the number, 0 to 2, of the chunk of a corner along y or z.
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

  // Returns the number of the point at a place that has one. The value at another place is undefined.
  [[nodiscard]] std::uint32_t operator[](int place) const { return numbers_[static_cast<std::size_t>(place)]; }

 private:
  std::array<std::uint32_t, NearPlaces::kCount> numbers_;
};

}  // namespace isoextract::extract

#include "base/hash.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

// Values of the reference implementation with seed 0 (S. Vigna, https://prng.di.unimi.it/splitmix64.c).
TEST(Hash, Splitmix64MatchesReference) {
  EXPECT_EQ(splitmix64(0), 0xE220A8397B1DCDAFU);
  EXPECT_EQ(splitmix64(1), 0x6E789E6AA1B965F4U);
  EXPECT_EQ(splitmix64(2), 0x06C45D188009454FU);
}

// Corners of neighboring triangles and origins of bricks have many zero bits, also when negative. A half-full table
// must not get long chains.
TEST(Hash, SpreadsRegularCoordinates) {
  constexpr std::size_t kTable = 1 << 16;
  for (const std::uint64_t step : {1U, 16U, 4096U}) {
    std::vector<int> taken(kTable, 0);
    for (std::uint64_t x = 0; x < 32; ++x) {
      for (std::uint64_t y = 0; y < 32; ++y) {
        for (std::uint64_t z = 0; z < 32; ++z) ++taken[hash_coordinates(x * step, (y - 16) * step, z * step) % kTable];
      }
    }
    EXPECT_LE(*std::max_element(taken.begin(), taken.end()), 8) << "step " << step;
  }
}

TEST(Hash, DependsOnOrderOfCoordinates) {
  EXPECT_NE(hash_coordinates(1, 2, 3), hash_coordinates(2, 3, 1));
  EXPECT_NE(hash_coordinates(1, 2, 3), hash_coordinates(1, 3, 2));
}

}  // namespace
}  // namespace isoextract

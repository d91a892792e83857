#include "base/hash.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

// What the reference implementation gives, started with 0 (S. Vigna, https://prng.di.unimi.it/splitmix64.c).
TEST(Hash, Splitmix64IsTheOneOfThePaper) {
  EXPECT_EQ(splitmix64(0), 0xE220A8397B1DCDAFU);
  EXPECT_EQ(splitmix64(1), 0x6E789E6AA1B965F4U);
  EXPECT_EQ(splitmix64(2), 0x06C45D188009454FU);
}

// Corners of neighbouring triangles, and origins of blocks, which have many zero bits, negative ones too: a table that
// is half full has no long chains.
TEST(Hash, SpreadsWhatIsRegular) {
  constexpr std::size_t kTable = 1 << 16;
  for (const std::uint64_t step : {1U, 16U, 4096U}) {
    std::vector<int> taken(kTable, 0);
    for (std::uint64_t x = 0; x < 32; ++x) {
      for (std::uint64_t y = 0; y < 32; ++y) {
        for (std::uint64_t z = 0; z < 32; ++z) ++taken[hash_of_three(x * step, (y - 16) * step, z * step) % kTable];
      }
    }
    EXPECT_LE(*std::max_element(taken.begin(), taken.end()), 8) << "step " << step;
  }
}

TEST(Hash, TheOrderOfTheThreeCounts) {
  EXPECT_NE(hash_of_three(1, 2, 3), hash_of_three(2, 3, 1));
  EXPECT_NE(hash_of_three(1, 2, 3), hash_of_three(1, 3, 2));
}

}  // namespace
}  // namespace isoextract

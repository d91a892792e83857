#include "accuracy/error_statistics.hpp"

#include <gtest/gtest.h>

namespace isoextract::accuracy {
namespace {

TEST(ErrorStatistics, HoldsDistancesOfAnySize) {
  ErrorAccumulator sums(2);
  for (const double voxels : {0x1p30, 0x1p31}) sums.add({voxels, 2 * voxels}, 1, glm::dvec3(0));
  const ErrorStatistics statistics = sums.result();
  EXPECT_EQ(statistics.percentile99.voxels, 0x1p31);
  EXPECT_EQ(statistics.percentile99.world, 0x1p32);
  EXPECT_GT(statistics.rms.voxels, 0x1p30);
}

TEST(ErrorStatistics, HasNoMeanWithoutArea) {
  ErrorAccumulator sums(2);
  sums.add({0.25, 0.5}, 0, glm::dvec3(0));
  sums.add({0.125, 0.25}, 0, glm::dvec3(0));
  const ErrorStatistics statistics = sums.result();
  for (const Length& length : {statistics.rms, statistics.percentile99, statistics.max}) {
    EXPECT_EQ(length.voxels, 0.25);
    EXPECT_EQ(length.world, 0.5);
  }
}

}  // namespace
}  // namespace isoextract::accuracy

#include "base/counted.hpp"

#include <cstdint>

#include <gtest/gtest.h>

namespace isoextract {
namespace {

TEST(Counted, UsesSingularForOneOnly) {
  EXPECT_EQ(counted(0, "hole"), "0 holes");
  EXPECT_EQ(counted(std::uint64_t{1}, "hole"), "1 hole");
  EXPECT_EQ(counted(2, "hole"), "2 holes");
  EXPECT_EQ(counted(1.0, "voxel"), "1 voxel");
  EXPECT_EQ(counted(1.5, "voxel"), "1.5 voxels");
}

TEST(Counted, AcceptsIrregularPlural) {
  EXPECT_EQ(counted(1, "vertex", "vertices"), "1 vertex");
  EXPECT_EQ(counted(2, "vertex", "vertices"), "2 vertices");
}

}  // namespace
}  // namespace isoextract

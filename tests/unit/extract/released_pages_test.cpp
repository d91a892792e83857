// Which pages of a slab of samples go back to the system. Anonymous memory is zero after its pages are released.
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

#include <gtest/gtest.h>
#include <sys/mman.h>

#include "extract/detail/brick_flags.hpp"

namespace isoextract::extract {
namespace {

constexpr int kRowsOfPage = 4;
constexpr glm::ivec3 kDims{4096 / kRowsOfPage, 64, 20};
constexpr std::size_t kBytes = std::size_t{kDims.x} * kDims.y * kDims.z;

class ReleasedPages : public testing::Test {
 protected:
  ReleasedPages()
      : samples_(static_cast<std::uint8_t*>(
            ::mmap(nullptr, kBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))),
        view_{samples_, kDims, kDims.x, std::int64_t{kDims.x} * kDims.y, true} {
    std::memset(samples_, 1, kBytes);
  }
  ~ReleasedPages() override { ::munmap(samples_, kBytes); }

  [[nodiscard]] bool is_there(int j, int k) const { return *view_.row(j, k) != 0; }

  std::uint8_t* samples_;
  DenseView<std::uint8_t> view_;
};

TEST_F(ReleasedPages, AreThoseOfTheRows) {
  view_.leave_rows(3, 5, 7, 25);  // whole pages hold rows 8 to 23
  for (int k = 0; k < kDims.z; ++k) {
    for (int j = 0; j < kDims.y; ++j) ASSERT_EQ(is_there(j, k), k < 3 || k >= 5 || j < 8 || j >= 24) << j << " " << k;
  }
}

TEST_F(ReleasedPages, AreNoneIfTheSamplesAreNotTransient) {
  view_.transient = false;
  view_.leave_rows(0, kDims.z, 0, kDims.y);
  EXPECT_TRUE(is_there(0, 0) && is_there(40, 10));
}

// Half of the rows go once, in slices 7 to 16 or 6 to 17, and none that a later row of bricks reads.
TEST_F(ReleasedPages, AreTheFirstHalfOfASlab) {
  for (const int around : {1, 2}) {
    std::memset(samples_, 1, kBytes);
    int released = 0;
    for (int bj = 0; kBrickRows * bj < kDims.y; ++bj) {
      leave_first_half(view_, 1, bj, around);
      for (int j = kBrickRows * (bj + 1) - around; j < kDims.y; ++j) ASSERT_TRUE(is_there(j, 10)) << bj << " " << j;
      if (!is_there(0, 10)) ++released;
      for (int k = 0; k < kDims.z; ++k) {
        const bool is_read = k >= 8 - around && k < 16 + around;
        ASSERT_EQ(is_there(0, k), !is_read || released == 0) << around << " " << k;
      }
      if (released > 0) {
        EXPECT_FALSE(is_there(kDims.y / 2 - kRowsOfPage, 10)) << bj;
      }
    }
    EXPECT_EQ(released, 4) << "the fifth row of bricks is the first that reads no row of the first half";
  }
}

// Samples behind a thin volume are not part of it.
TEST_F(ReleasedPages, AreThoseOfTheVolume) {
  for (int rows = 1; rows < 2 * kBrickRows; ++rows) {
    for (const int around : {1, 2}) {
      std::memset(samples_, 1, kBytes);
      view_.dims = {kDims.x, rows, 8};
      view_.stride_z = std::int64_t{kDims.x} * rows;
      for (int bj = 0; kBrickRows * bj < rows; ++bj) leave_first_half(view_, 0, bj, around);
      const std::size_t bytes = static_cast<std::size_t>(view_.stride_z) * 8;
      const auto* released = std::find(samples_ + bytes, samples_ + kBytes, 0);
      EXPECT_EQ(released, samples_ + kBytes) << rows << " " << around;
    }
  }
}

}  // namespace
}  // namespace isoextract::extract

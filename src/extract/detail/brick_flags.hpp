// Marks the bricks of dense samples that the surface crosses.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "extract/dense_input.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/slab_shares.hpp"

namespace isoextract::extract {

// Marks the bricks that have samples on both sides of the iso value. The samples of a brick include those that its last
// cells share with the next brick.
class BrickFlags {
 public:
  // `dims` is the number of samples along each axis. Has memory only for `slabs`, a range of brick layers along z.
  BrickFlags(const glm::ivec3& dims, const SlabRange& slabs)
      : dims_(dims),
        slabs_(slabs),
        words_((dims.x + 63) / 64),
        rows_y_((dims.y + kBrickRows - 1) / kBrickRows),
        rows_z_(count_slabs(dims)) {}

  [[nodiscard]] static int count_slabs(const glm::ivec3& dims) { return (dims.z + kBrickRows - 1) / kBrickRows; }

  [[nodiscard]] std::uint64_t bytes() const { return offset(0, slabs_.end); }
  void allocate() { crossed_ = Buffer<std::uint8_t>(bytes()); }

  [[nodiscard]] int rows_y() const { return rows_y_; }
  [[nodiscard]] int rows_z() const { return rows_z_; }
  [[nodiscard]] std::uint64_t count() const {
    return static_cast<std::uint64_t>(words_) * static_cast<std::uint64_t>(rows_y_) *
           static_cast<std::uint64_t>(rows_z_);
  }
  // Returns how many bricks of these slabs are crossed.
  [[nodiscard]] std::uint64_t count_crossed(const SlabRange& slabs) const {
    return static_cast<std::uint64_t>(std::count(row(0, slabs.begin), row(0, slabs.end), std::uint8_t{1}));
  }

  // Returns the flags of brick row (bj, bk): one byte for each word of 64 samples along x.
  [[nodiscard]] const std::uint8_t* row(int bj, int bk) const { return crossed_.data() + offset(bj, bk); }

  [[nodiscard]] bool is_row_crossed(int bj, int bk) const {
    return std::find(row(bj, bk), row(bj, bk) + words_, 1) != row(bj, bk) + words_;
  }

  // Marks the crossed bricks of brick row (bj, bk).
  void mark_crossed(const DenseMasks& masks, int bj, int bk) {
    std::array<const std::uint64_t*, (kBrickRows + 1) * (kBrickRows + 1)> rows;
    std::size_t count = 0;
    for (int k = kBrickRows * bk; k < std::min(kBrickRows * (bk + 1) + 1, dims_.z); ++k) {
      for (int j = kBrickRows * bj; j < std::min(kBrickRows * (bj + 1) + 1, dims_.y); ++j) {
        rows[count++] = masks.row(j, k);
      }
    }
    mark_crossed_words(std::span(rows).first(count), dims_.x, crossed_.data() + offset(bj, bk));
  }

 private:
  [[nodiscard]] std::size_t offset(int bj, int bk) const {
    return static_cast<std::size_t>(words_) *
           (static_cast<std::size_t>(bj) +
            static_cast<std::size_t>(rows_y_) * static_cast<std::size_t>(bk - slabs_.begin));
  }

  glm::ivec3 dims_;
  SlabRange slabs_;
  int words_;
  int rows_y_;
  int rows_z_;
  Buffer<std::uint8_t> crossed_;
};

// Returns the cells of row (j, k). `masks` and `bricks` cover them; `dims` is the number of samples along each axis.
[[nodiscard]] inline CellRow cell_row(const DenseMasks& masks, const BrickFlags& bricks, const glm::ivec3& dims, int j,
                                      int k) {
  CellRow row;
  row.origin = {0, j, k};
  for (int r = 0; r < 4; ++r) {
    const int y = j + (r & 1);
    const int z = k + (r >> 1);
    row.bits[static_cast<std::size_t>(r)] = y < dims.y && z < dims.z ? masks.row(y, z) : nullptr;
  }
  row.samples = dims.x;
  row.crossed_bricks = bricks.row(j / kBrickRows, k / kBrickRows);
  return row;
}

}  // namespace isoextract::extract

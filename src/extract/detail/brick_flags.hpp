// Marks the bricks of dense samples that the surface crosses. Gives pages of mapped samples back.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
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

inline constexpr int kSlicesAtWork = 4;  // read for the vertices of one slice, with normals

// Returns whether pages of a mapped file may stay in memory for as many slices a thread.
template <class T>
[[nodiscard]] bool may_stay(const DenseView<T>& view, int slices) {
  constexpr std::int64_t kMost = std::int64_t{96} << 20U;  // bytes
  return !view.transient || usable_threads() * slices * view.stride_z * std::int64_t{sizeof(T)} <= kMost;
}

// Returns whether the pages of slabs may stay until their vertices are made. Otherwise each slice is released after
// each look at it, which takes longer. So much memory is for volumes beside which it is little.
template <class T>
[[nodiscard]] bool slabs_may_stay(const DenseView<T>& view) {
  constexpr int kLeastPart = 50;  // a fiftieth of the samples
  const bool is_small_part = kLeastPart * usable_threads() * kSlabSlices <= view.dims.z;
  return !view.transient || (is_small_part && may_stay(view, kSlabSlices));
}

// Releases the pages of the slices of slab `bk` and of `around` slices on either side. Slab `bk` reads these outer
// slices, too, and may have brought their pages back after the neighboring slab released them.
template <class T>
void leave_slab(const DenseView<T>& view, int bk, int around) {
  view.leave_slices(std::max(kBrickRows * bk - around, 0), std::min(kBrickRows * (bk + 1) + around, view.dims.z));
}

// Releases the pages of runs of rows while slab `bk` is at work: call it after each row of bricks `bj`, in order. Keeps
// slices that the next slab begins with, as another thread may be reading them.
template <class T>
void leave_brick_row(const DenseView<T>& view, int bk, int bj) {
  // Every release interrupts all threads, so many threads release less often.
  const std::int64_t run = std::int64_t{1} << (usable_threads() > 8 ? 20U : 18U);  // bytes
  const std::int64_t touched = std::min<std::int64_t>(view.stride_y * sizeof(T), view.dims.x * sizeof(T) + 4096);
  const int rows = static_cast<int>(std::max<std::int64_t>(run / (kBrickRows * touched), 1));
  const int end = std::min(kBrickRows * (bj + 1), view.dims.y);
  if ((bj + 1) % rows != 0 && end != view.dims.y) return;
  // The run reads the last row of the run before it again, and the system maps pages around it.
  const int begin = kBrickRows * std::max(bj / rows * rows - 1, 0);
  const int end_z = std::min(kBrickRows * (bk + 1), view.dims.z);
  for (int k = kBrickRows * bk; k < end_z; ++k) view.leave_rows(begin, end, k);
}

}  // namespace isoextract::extract

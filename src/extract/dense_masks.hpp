// One bit a sample: inside or not. The code that counts and writes triangles works on these bits, and reads samples
// only near crossed edges.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>

#include "base/buffer.hpp"
#include "base/memory_budget.hpp"
#include "base/pages.hpp"
#include "base/progress.hpp"
#include "extract/inside_test.hpp"

namespace isoextract::extract {

// A box within a dense array. `data` points to sample (0, 0, first_slice), which need not be part of the box; x is
// contiguous; strides count samples.
template <class T>
struct DenseView {
  const T* data;
  glm::ivec3 dims;
  std::int64_t stride_y;
  std::int64_t stride_z;
  bool transient = false;  // the samples are a large mapped file; release pages early
  int first_slice = 0;     // not 0 if only some slices (planes of equal z) are in memory, or in a part of such a view

  [[nodiscard]] const T* row(int j, int k) const { return data + j * stride_y + (k - first_slice) * stride_z; }

  // Releases the memory pages of slices begin to end - 1 (planes of equal z). The slices can still be read later.
  void leave_slices(int begin, int end) const {
    if (!transient || begin >= end) return;
    release_pages(row(0, begin), bytes_of_slices(begin, end));
  }

  // Releases those of rows begin to end - 1 of slice `k`.
  void leave_rows(int begin, int end, int k) const {
    if (!transient || begin >= end) return;
    release_pages(row(begin, k), static_cast<std::size_t>(row(end - 1, k) + dims.x - row(begin, k)) * sizeof(T));
  }

  // Returns the page requests for a pass over the samples of slices begin to end - 1.
  [[nodiscard]] PageRequests page_requests(int begin, int end) const {
    if (!transient || begin >= end || has_wide_gaps()) return {};
    return {row(0, begin), bytes_of_slices(begin, end)};
  }

 private:
  // Returns whether much of the file between rows or slices is not part of the view, so requests should not cover it.
  [[nodiscard]] bool has_wide_gaps() const {
    constexpr std::int64_t kWide = std::int64_t{1} << 16U;  // bytes; the system reads up to so much ahead on its own
    const std::int64_t between_rows = stride_y - dims.x;
    const std::int64_t between_slices = stride_z - (dims.y - 1) * stride_y - dims.x;
    return std::max(between_rows, between_slices) * std::int64_t{sizeof(T)} > kWide;
  }

  [[nodiscard]] std::size_t bytes_of_slices(int begin, int end) const {
    return static_cast<std::size_t>(row(dims.y - 1, end - 1) + dims.x - row(0, begin)) * sizeof(T);
  }
};

class DenseMasks {
 public:
  // `memory` is the reservation of bytes(dims) bytes.
  explicit DenseMasks(const glm::ivec3& dims, Reservation memory = {}) : DenseMasks(dims, dims.z, std::move(memory)) {}
  // Makes masks with room for `slices` slices (planes of equal z). The first of them is slice 0, or the slice
  // given to move_to(). `memory` is the reservation of bytes({dims.x, dims.y, slices}) bytes.
  DenseMasks(const glm::ivec3& dims, int slices, Reservation memory)
      : dims_(dims),
        words_((dims.x + 63) / 64),
        memory_(std::move(memory)),
        bits_(bytes({dims.x, dims.y, slices}) / sizeof(std::uint64_t)) {}
  void move_to(int slice) { first_slice_ = slice; }

  [[nodiscard]] static std::uint64_t bytes(const glm::ivec3& dims) {
    const glm::u64vec3 wide(dims);
    return ((wide.x + 63) / 64 + 1) * wide.y * wide.z * sizeof(std::uint64_t);
  }

  [[nodiscard]] const glm::ivec3& dims() const { return dims_; }
  [[nodiscard]] int words() const { return words_; }

  // Row (j, k) is words() words and one zero word after them. Bits from dims().x on are zero. Uninitialized before
  // classify().
  [[nodiscard]] const std::uint64_t* row(int j, int k) const { return bits_.data() + offset(j, k); }
  [[nodiscard]] std::uint64_t* row(int j, int k) { return bits_.data() + offset(j, k); }

  // Returns a hash of the masks of slices begin to end - 1.
  [[nodiscard]] std::uint64_t hash(int begin, int end) const;

  [[nodiscard]] bool inside(const glm::ivec3& p) const { return (row(p.y, p.z)[p.x / 64] >> (p.x % 64) & 1) != 0; }

  // Returns the sides of the outermost samples. Valid after classify(); classify_slice() does not set them.
  [[nodiscard]] const BoundarySides& boundary_sides() const { return boundary_sides_; }
  void set_boundary(const BoundarySides& sides) { boundary_sides_ = sides; }

  // Returns the sides of the outermost samples in row (j, k).
  [[nodiscard]] BoundarySides boundary_of_row(int j, int k) const;

 private:
  [[nodiscard]] std::size_t offset(int j, int k) const {
    return static_cast<std::size_t>(words_ + 1) *
           (static_cast<std::size_t>(j) +
            static_cast<std::size_t>(dims_.y) * static_cast<std::size_t>(k - first_slice_));
  }

  glm::ivec3 dims_;
  int words_;
  int first_slice_ = 0;
  Reservation memory_;
  Buffer<std::uint64_t> bits_;
  BoundarySides boundary_sides_;
};

// Returns the index within the view of the first NaN of slices begin to end - 1; nullopt if there is none.
template <class T>
[[nodiscard]] std::optional<glm::ivec3> first_nan(const DenseView<T>& view, int begin, int end) {
  glm::ivec3 p(0);
  for (p.z = begin; p.z < end; ++p.z) {
    for (p.y = 0; p.y < view.dims.y; ++p.y) {
      const T* row = view.row(p.y, p.z);
      for (p.x = 0; p.x < view.dims.x; ++p.x) {
        if (std::isnan(static_cast<double>(row[p.x]))) return p;
      }
    }
  }
  return std::nullopt;
}

// Facts about the samples of a slice.
struct SliceSides {
  std::uint64_t nan = 0;  // samples that are NaN
  BoundarySides boundary;

  void add(const SliceSides& other) {
    nan += other.nan;
    boundary.inside |= other.boundary.inside;
    boundary.outside |= other.boundary.outside;
  }
};

// Fills the masks of slice `k` of the view; returns its NaN count and boundary sides. `masks` has the dims of the view.
// `requests` are those of the pass over the view.
template <class T>
SliceSides classify_slice(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks, int k,
                          PageRequests& requests);

// Reads every sample once, in parallel. Fills `masks`, which have the dims of the view, and their boundary sides.
// Returns the number of NaN samples. `progress` may be null. Calls after_slice(k, facts) once the masks of slice `k`
// are filled; several threads may do so at once. Slices come in about ascending order. The pass ends if after_slice()
// returns false; the facts are then those of some slices. Without after_slice(), releases the pages of each slice.
template <class T>
std::uint64_t classify(const DenseView<T>& view, const InsideThreshold<T>& threshold, DenseMasks& masks,
                       Progress* progress,
                       const std::function<bool(int slice, const SliceSides& facts)>& after_slice = {});

}  // namespace isoextract::extract

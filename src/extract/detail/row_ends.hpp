// The first and the last sample of every row of samples: inside or outside.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "extract/dense_masks.hpp"

namespace isoextract::extract {

// For a cap of a volume whose masks are not kept: to look at the two samples of each row again would read every page of
// a mapped file once more.
class RowEnds {
 public:
  // Covers the slices from `first_slice` to end_slice - 1; no slice without `is_kept`.
  RowEnds(const glm::ivec3& dims, int first_slice, int end_slice, bool is_kept)
      : dims_(dims), first_slice_(first_slice), slices_(is_kept ? end_slice - first_slice : 0) {}

  [[nodiscard]] std::size_t bytes() const {
    return static_cast<std::size_t>(dims_.y) * static_cast<std::size_t>(slices_);
  }
  void allocate() { sides_ = Buffer<std::uint8_t>(bytes()); }

  // Several threads may mark rows at once. Does nothing if no slice is covered.
  void mark(const DenseMasks& masks, int j, int k) {
    if (sides_.empty()) return;
    const bool last = masks.inside({dims_.x - 1, j, k});
    sides_[index(j, k)] = static_cast<std::uint8_t>((masks.inside({0, j, k}) ? kFirst : 0) | (last ? kLast : 0));
  }

  // Returns whether the sample is at the end of a marked row.
  [[nodiscard]] bool knows(const glm::ivec3& p) const { return !sides_.empty() && (p.x == 0 || p.x == dims_.x - 1); }
  // Returns whether such a sample is inside.
  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    return (sides_[index(p.y, p.z)] & (p.x == 0 ? kFirst : kLast)) != 0;
  }

 private:
  static constexpr int kFirst = 1;
  static constexpr int kLast = 2;

  [[nodiscard]] std::size_t index(int j, int k) const {
    return static_cast<std::size_t>(j) + static_cast<std::size_t>(dims_.y) * static_cast<std::size_t>(k - first_slice_);
  }

  glm::ivec3 dims_;
  int first_slice_;
  int slices_;
  Buffer<std::uint8_t> sides_;
};

}  // namespace isoextract::extract

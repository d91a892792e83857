// How much of a large mapped file stays in memory while its surface is extracted, and the release of its pages.
#pragma once

#include <algorithm>
#include <cstdint>

#include "base/parallel.hpp"
#include "extract/dense_input.hpp"

namespace isoextract::extract {

inline constexpr int kSlicesAtWork = 4;  // slices (planes of equal z) read for the vertices of one, with normals

// Returns whether the pages of as many slices may stay in memory for each thread.
[[nodiscard]] inline bool may_stay(int slices, std::int64_t slice_bytes) {
  constexpr std::int64_t kMost = std::int64_t{96} << 20U;  // bytes
  return usable_threads() * slices * slice_bytes <= kMost;
}

// Returns whether the pages of slabs may stay until their vertices are made. Otherwise each slice is released after
// each look at it, which takes longer. So much memory is for volumes beside which it is little. `slices` is the number
// of slices of the volume.
[[nodiscard]] inline bool slabs_may_stay(std::int64_t slices, std::int64_t slice_bytes) {
  constexpr int kLeastPart = 25;  // a twenty-fifth of the samples
  return kLeastPart * usable_threads() * kSlabSlices <= slices && may_stay(kSlabSlices, slice_bytes);
}

[[nodiscard]] inline bool slabs_may_stay(const field::DenseSamples& samples) {
  const std::int64_t slice = std::int64_t{samples.dims.x} * samples.dims.y;
  return slabs_may_stay(samples.dims.z, slice * static_cast<std::int64_t>(field::sample_size(samples.type)));
}

template <class T>
[[nodiscard]] bool may_stay(const DenseView<T>& view, int slices) {
  return !view.transient || may_stay(slices, view.stride_z * std::int64_t{sizeof(T)});
}
template <class T>
[[nodiscard]] bool slabs_may_stay(const DenseView<T>& view) {
  return !view.transient || slabs_may_stay(view.dims.z, view.stride_z * std::int64_t{sizeof(T)});
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

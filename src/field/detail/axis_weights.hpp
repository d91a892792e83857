// Resampling weights along one axis: interpolation kernels if the new samples are denser than the old ones, means if
// they are sparser. Private to resample.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "field/resample.hpp"

namespace isoextract::field {

// The weights of the old samples `first`, `first` + 1, ..., which add up to 1.
struct SampleWeights {
  int first = 0;
  std::span<const double> weights;
  // For kernels: the new sample lies at below + t, in steps of the old samples.
  int below = 0;
  double t = 0;

  [[nodiscard]] int end() const { return first + static_cast<int>(weights.size()); }  // behind the last old sample
};

// Returns whether the kernel takes every new sample from an old one. On the axes that AxisWeights handles, majority
// works like nearest.
[[nodiscard]] constexpr bool takes_old_samples(ResampleKernel kernel) {
  return kernel == ResampleKernel::nearest || kernel == ResampleKernel::majority;
}

class AxisWeights {
 public:
  static constexpr int kMaxKernelWeights = 4;  // the most weights of a kernel

  // Both grids start and end at the same positions and have at least two samples. `means` allows means where the new
  // grid is coarser.
  AxisWeights(int old_count, int new_count, ResampleKernel kernel, bool means);

  // Returns the bytes that the caller must reserve.
  [[nodiscard]] static std::uint64_t bytes(int old_count, int new_count);

  [[nodiscard]] bool is_mean() const { return mean_; }
  // Returns whether no weight is negative, so that new samples lie within the range of the old ones.
  [[nodiscard]] bool is_convex() const { return convex_; }
  [[nodiscard]] SampleWeights of(int i) const {
    const Entry& entry = entries_[static_cast<std::size_t>(i)];
    return {entry.first, std::span(weights_).subspan(entry.begin, entry.count), entry.below, entry.t};
  }

 private:
  struct Entry {
    int first = 0;
    int below = 0;
    double t = 0;
    std::size_t begin = 0;
    std::size_t count = 0;
  };

  void add_mean(Entry entry, double half_width, int old_count);
  void add_kernel(Entry entry, ResampleKernel kernel, int old_count);

  std::vector<Entry> entries_;
  std::vector<double> weights_;
  bool mean_;
  bool convex_;
};

}  // namespace isoextract::field

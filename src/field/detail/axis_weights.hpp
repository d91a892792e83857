// Which old samples a new one is made of along one axis, and with which weights: a kernel between the samples where the
// new ones are nearer to each other, means where they are farther apart. Private to resample.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "field/resample.hpp"

namespace isoextract::field {

// Old samples `first`, `first` + 1 and so on, as many as there are weights. The weights add up to 1.
struct SampleWeights {
  int first = 0;
  std::span<const double> weights;
  // Of a kernel: the place is (1 - t) of `below`, t of the next.
  int below = 0;
  double t = 0;
};

class AxisWeights {
 public:
  static constexpr int kMostOfKernel = 4;  // weights

  // The first new sample is the first old one, the last the last. At least two of either.
  AxisWeights(int old_count, int new_count, ResampleKernel kernel, bool means);

  // For the caller to reserve.
  [[nodiscard]] static std::uint64_t bytes(int old_count, int new_count);

  [[nodiscard]] bool is_mean() const { return mean_; }
  // No weight is below 0: what is made lies between the old samples.
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

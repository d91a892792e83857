#include "field/detail/axis_weights.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace isoextract::field {
namespace {

// Returns the part of a voxel, a box of width 1 around its sample at 0, that lies below `u`.
double voxel_until(double u) { return std::clamp(u + 0.5, 0.0, 1.0); }

// Returns the weights of the samples below - 1 to below + 2.
std::array<double, AxisWeights::kMaxKernelWeights> kernel_weights(ResampleKernel kernel, double t) {
  const double u = 1 - t;
  switch (kernel) {
    case ResampleKernel::cubic:
      return {-t * u * u / 2, (2 - t * t * (5 - 3 * t)) / 2, (2 - u * u * (5 - 3 * u)) / 2, -u * t * t / 2};
    case ResampleKernel::bspline:
      return {u * u * u / 6, (4 - t * t * (6 - 3 * t)) / 6, (4 - u * u * (6 - 3 * u)) / 6, t * t * t / 6};
    case ResampleKernel::nearest:
    case ResampleKernel::majority:
    case ResampleKernel::linear: break;
  }
  return {0, u, t, 0};
}

// Moves weights outside the boundary to the samples inside. The B-spline extrapolates the line through the last two
// samples, which stays convex because the outer weight is at most a sixth. Catmull-Rom extrapolates the parabola
// through the last three, as Interpolant does, so that boundary slopes are one-sided differences of the same order.
void fold(std::array<double, AxisWeights::kMaxKernelWeights>& weights, bool low, bool high, ResampleKernel kernel,
          int old_count) {
  const bool parabola = kernel == ResampleKernel::cubic && old_count > 2;
  auto& [before, a, b, after] = weights;
  // With three or more samples, the third is within the weights unless both boundaries are near.
  if (low) {
    if (parabola) {
      a += 3 * before;
      b -= 3 * before;
      after += before;
    } else {
      a += 2 * before;
      b -= before;
    }
    before = 0;
  }
  if (high) {
    if (parabola && !low) {
      b += 3 * after;
      a -= 3 * after;
      before += after;
    } else {
      b += 2 * after;
      a -= after;
    }
    after = 0;
  }
}

}  // namespace

std::uint64_t AxisWeights::bytes(int old_count, int new_count) {
  const auto old_samples = static_cast<std::uint64_t>(old_count);
  const auto new_samples = static_cast<std::uint64_t>(new_count);
  // A growing vector holds its numbers twice for a while.
  return new_samples * sizeof(Entry) + 2 * sizeof(double) * (old_samples + kMaxKernelWeights * new_samples);
}

AxisWeights::AxisWeights(int old_count, int new_count, ResampleKernel kernel, bool means)
    : mean_(means && new_count < old_count && !takes_old_samples(kernel)),
      convex_(mean_ || kernel != ResampleKernel::cubic) {
  entries_.reserve(static_cast<std::size_t>(new_count));
  const std::int64_t steps = new_count - 1;
  const double half_step = static_cast<double>(old_count - 1) / static_cast<double>(steps) / 2;
  for (int i = 0; i < new_count; ++i) {
    const std::int64_t scaled = std::int64_t{i} * (old_count - 1);
    Entry entry;
    entry.below = static_cast<int>(scaled / steps);
    entry.t = static_cast<double>(scaled % steps) / static_cast<double>(steps);
    entry.begin = weights_.size();
    const double place = entry.below + entry.t;
    if (mean_) {
      add_mean(entry, std::min(half_step, std::min(place, old_count - 1 - place) + 0.5), old_count);
    } else {
      add_kernel(entry, kernel, old_count);
    }
  }
}

// Averages the voxels within `half_width` of the new sample. A voxel partly within has that part of the weight.
void AxisWeights::add_mean(Entry entry, double half_width, int old_count) {
  const double place = entry.below + entry.t;
  const double low = place - half_width;
  const double high = place + half_width;
  entry.first = std::max(static_cast<int>(std::floor(low + 0.5)), 0);
  const int last = std::min(static_cast<int>(std::ceil(high - 0.5)), old_count - 1);
  double sum = 0;
  for (int j = entry.first; j <= last; ++j) {
    weights_.push_back(voxel_until(high - j) - voxel_until(low - j));
    sum += weights_.back();
  }
  for (std::size_t k = entry.begin; k < weights_.size(); ++k) weights_[k] /= sum;
  entry.count = weights_.size() - entry.begin;
  // A sample of weight 0 must not contribute, because it may be NaN.
  while (entry.count > 1 && weights_.back() == 0) {
    weights_.pop_back();
    --entry.count;
  }
  if (weights_[entry.begin] == 0 && entry.count > 1) {
    weights_.erase(weights_.begin() + static_cast<std::ptrdiff_t>(entry.begin));
    ++entry.first;
    --entry.count;
  }
  entries_.push_back(entry);
}

void AxisWeights::add_kernel(Entry entry, ResampleKernel kernel, int old_count) {
  const bool passes_through = kernel != ResampleKernel::bspline;
  if (takes_old_samples(kernel) || (passes_through && entry.t == 0)) {
    entry.first = entry.t > 0.5 ? entry.below + 1 : entry.below;
    entry.count = 1;
    weights_.push_back(1);
    entries_.push_back(entry);
    return;
  }
  // The last sample is the end of the last step, and there is at least one step.
  if (entry.below == old_count - 1) {
    --entry.below;
    entry.t = 1;
  }
  auto weights = kernel_weights(kernel, entry.t);
  fold(weights, entry.below == 0, entry.below + 2 >= old_count, kernel, old_count);
  std::size_t begin = 0;
  std::size_t end = weights.size();
  while (weights[begin] == 0) ++begin;
  while (weights[end - 1] == 0) --end;
  entry.first = entry.below - 1 + static_cast<int>(begin);
  entry.count = end - begin;
  weights_.insert(weights_.end(), weights.begin() + static_cast<std::ptrdiff_t>(begin),
                  weights.begin() + static_cast<std::ptrdiff_t>(end));
  entries_.push_back(entry);
}

}  // namespace isoextract::field

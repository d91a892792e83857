// Vectorized sums of cubic splines (cubic_spline.hpp). Adds sources in the order of the batch, one addition each,
// without fused multiply-add, so results are bit-identical for every instruction set.
#pragma once

#include <array>
#include <cstddef>

namespace isoextract::points {

inline constexpr std::size_t kBatch = 512;

// Balls of radius 1 around (x, y, z): S is 0 at the surface and the contribution at the center is `weight` >= 0.
struct BallBatch {
  alignas(64) std::array<float, kBatch> x;
  alignas(64) std::array<float, kBatch> y;
  alignas(64) std::array<float, kBatch> z;
  alignas(64) std::array<float, kBatch> weight;
  std::size_t size = 0;
};

// Ellipsoids: S(sqrt(d^T M d)) at d from the center, with the entries of the symmetric matrix M.
struct EllipsoidBatch : BallBatch {
  alignas(64) std::array<float, kBatch> xx;
  alignas(64) std::array<float, kBatch> xy;
  alignas(64) std::array<float, kBatch> xz;
  alignas(64) std::array<float, kBatch> yy;
  alignas(64) std::array<float, kBatch> yz;
  alignas(64) std::array<float, kBatch> zz;
};

// Adds the balls to the 512 samples of a block in the order of field::SparseBlock; sample (i, j, k) is at step * (i, j,
// k). Skips, for each ball, rows of samples along z farther than `cut` from its center; a cut of 1 skips only rows
// without a contribution. A ball's contribution to a sample that is not skipped does not depend on `cut`.
void add_balls(const BallBatch& balls, float step, float cut, float* values);

// Does the same for ellipsoids; `cut` is a fraction of their axes.
void add_ellipsoids(const EllipsoidBatch& ellipsoids, float step, float cut, float* values);

// Adds the contributions of the balls at `count` targets, a multiple of 8, to `sums`.
void add_at_targets(const BallBatch& balls, const float* x, const float* y, const float* z, std::size_t count,
                    float* sums);

// Moments of the points nearer than 1 to each of at most 64 targets, relative to the target, with the weight w = weight
// * (1 - distance^3).
struct Moments {
  static constexpr std::size_t kTargets = 64;
  enum Sum : std::size_t { kPoints, kTotal, kX, kY, kZ, kXX, kXY, kXZ, kYY, kYZ, kZZ, kSums };
  // kPoints sums the plain weights, kTotal sums w, kX sums w * x, kXX sums w * x^2, and so on.
  alignas(64) std::array<std::array<float, kTargets>, kSums> sums{};
};

// Adds to the moments of `count` targets, a multiple of 8.
void add_moments(const BallBatch& points, const float* x, const float* y, const float* z, std::size_t count,
                 Moments& moments);

}  // namespace isoextract::points

// Sums of cubic splines (cubic_spline.hpp), vectorised. Every sum is taken in the order of the batch, one addition a
// source and no multiplication fused with one, so results are the same bits for every instruction set.
#pragma once

#include <array>
#include <cstddef>

namespace isoextract::points {

inline constexpr std::size_t kBatch = 512;

// Balls around (x, y, z) with a radius of 1, where S is 0; at the centre each counts `weight`, which is at least 0.
struct BallBatch {
  alignas(64) std::array<float, kBatch> x;
  alignas(64) std::array<float, kBatch> y;
  alignas(64) std::array<float, kBatch> z;
  alignas(64) std::array<float, kBatch> weight;
  std::size_t size = 0;
};

// Ellipsoids: S of sqrt(d^T M d) at d from the centre, with the entries of the symmetric M.
struct EllipsoidBatch : BallBatch {
  alignas(64) std::array<float, kBatch> xx;
  alignas(64) std::array<float, kBatch> xy;
  alignas(64) std::array<float, kBatch> xz;
  alignas(64) std::array<float, kBatch> yy;
  alignas(64) std::array<float, kBatch> yz;
  alignas(64) std::array<float, kBatch> zz;
};

// Adds the balls to the 512 samples of a block in the order of field::SparseBlock; sample (i, j, k) is at step * (i, j,
// k). Rows of samples along z that are farther than `cut` from a ball's centre are left out for it; with 1 none is that
// would get anything. What a sample gets from one ball does not depend on `cut`, unless it gets nothing.
void add_balls(const BallBatch& balls, float step, float cut, float* values);

// Likewise, `cut` as a part of the ellipsoids.
void add_ellipsoids(const EllipsoidBatch& ellipsoids, float step, float cut, float* values);

// Adds to `sums` what the balls are at `count` targets, a multiple of 8.
void add_at_targets(const BallBatch& balls, const float* x, const float* y, const float* z, std::size_t count,
                    float* sums);

// Moments of the points nearer than 1 to each of at most 64 targets, about the target, by the weight
// w = weight * (1 - distance^3).
struct Moments {
  static constexpr std::size_t kTargets = 64;
  enum Sum : std::size_t { kPoints, kTotal, kX, kY, kZ, kXX, kXY, kXZ, kYY, kYZ, kZZ, kSums };
  // kPoints is the sum of the weights, kTotal that of w, kX that of w * x, kXX that of w * x^2, ...
  alignas(64) std::array<std::array<float, kTargets>, kSums> sums{};
};

// Adds to those of `count` targets, a multiple of 8.
void add_moments(const BallBatch& points, const float* x, const float* y, const float* z, std::size_t count,
                 Moments& moments);

}  // namespace isoextract::points

#include "points/detail/spline_sums.hpp"

#include "base/simd_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "points/detail/spline_sums.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::points {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Rows and targets come in eights.
using Lanes = hn::CappedTag<float, 8>;
using Floats = hn::Vec<Lanes>;

// weight * S(q) by its square, as spline_shape().
HWY_INLINE Floats spline(Lanes d, Floats squared, Floats weight) {
  const Floats zero = hn::Zero(d);
  const Floats one = hn::Set(d, 1);
  const Floats outer = hn::Max(zero, hn::Sub(one, hn::Sqrt(squared)));
  const Floats inner = hn::Max(zero, hn::Sub(hn::Add(outer, outer), one));
  const Floats outer_cubed = hn::Mul(hn::Mul(outer, outer), outer);
  const Floats inner_cubed = hn::Mul(hn::Mul(inner, inner), inner);
  return hn::Mul(weight, hn::Sub(hn::Add(outer_cubed, outer_cubed), inner_cubed));
}

HWY_INLINE void add_to(Lanes d, Floats v, float* sums) { hn::Store(hn::Add(hn::Load(d, sums), v), d, sums); }

void balls_in_rows(const BallBatch& balls, float step, float cut, float* values) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  const float cut_squared = cut * cut;
  alignas(64) float at[8];
  for (int i = 0; i < 8; ++i) at[i] = step * static_cast<float>(i);
  alignas(64) float z_squared[8];
  float y_squared[8];
  for (std::size_t n = 0; n < balls.size; ++n) {
    const Floats z = hn::Set(d, balls.z[n]);
    for (std::size_t k = 0; k < 8; k += lanes) {
      const Floats away = hn::Sub(hn::Load(d, at + k), z);
      hn::Store(hn::Mul(away, away), d, z_squared + k);
    }
    for (int j = 0; j < 8; ++j) y_squared[j] = (at[j] - balls.y[n]) * (at[j] - balls.y[n]);
    const Floats weight = hn::Set(d, balls.weight[n]);
    for (int i = 0; i < 8; ++i) {
      const float x_squared = (at[i] - balls.x[n]) * (at[i] - balls.x[n]);
      if (x_squared >= cut_squared) continue;
      for (int j = 0; j < 8; ++j) {
        const float from_row = x_squared + y_squared[j];
        if (from_row >= cut_squared) continue;
        const Floats row = hn::Set(d, from_row);
        float* const sums = values + 64 * i + 8 * j;
        for (std::size_t k = 0; k < 8; k += lanes) {
          add_to(d, spline(d, hn::Add(row, hn::Load(d, z_squared + k)), weight), sums + k);
        }
      }
    }
  }
}

void ellipsoids_in_rows(const EllipsoidBatch& ellipsoids, float step, float cut, float* values) {
  const Lanes d;
  const std::size_t lanes = hn::Lanes(d);
  const float cut_squared = cut * cut;
  const Floats zero = hn::Zero(d);
  alignas(64) float at[8];
  for (int i = 0; i < 8; ++i) at[i] = step * static_cast<float>(i);
  for (std::size_t n = 0; n < ellipsoids.size; ++n) {
    const float zz = ellipsoids.zz[n];
    const float over_four_zz = 1 / (4 * zz);
    const Floats weight = hn::Set(d, ellipsoids.weight[n]);
    const Floats z = hn::Set(d, ellipsoids.z[n]);
    for (int i = 0; i < 8; ++i) {
      const float x = at[i] - ellipsoids.x[n];
      for (int j = 0; j < 8; ++j) {
        // Along the row the form is constant + linear * z + zz * z^2; its least value says whether the row is left out.
        const float y = at[j] - ellipsoids.y[n];
        const float linear = 2 * (ellipsoids.xz[n] * x + ellipsoids.yz[n] * y);
        const float constant = ellipsoids.xx[n] * x * x + 2 * ellipsoids.xy[n] * x * y + ellipsoids.yy[n] * y * y;
        if (constant - linear * linear * over_four_zz >= cut_squared) continue;
        float* const sums = values + 64 * i + 8 * j;
        for (std::size_t k = 0; k < 8; k += lanes) {
          const Floats away = hn::Sub(hn::Load(d, at + k), z);
          const Floats slope = hn::Add(hn::Set(d, linear), hn::Mul(hn::Set(d, zz), away));
          const Floats squared = hn::Max(zero, hn::Add(hn::Set(d, constant), hn::Mul(away, slope)));
          add_to(d, spline(d, squared, weight), sums + k);
        }
      }
    }
  }
}

void balls_at_targets(const BallBatch& balls, const float* x, const float* y, const float* z, std::size_t count,
                      float* sums) {
  const Lanes d;
  for (std::size_t t = 0; t < count; t += hn::Lanes(d)) {
    const Floats tx = hn::LoadU(d, x + t);
    const Floats ty = hn::LoadU(d, y + t);
    const Floats tz = hn::LoadU(d, z + t);
    Floats sum = hn::LoadU(d, sums + t);
    for (std::size_t n = 0; n < balls.size; ++n) {
      const Floats dx = hn::Sub(tx, hn::Set(d, balls.x[n]));
      const Floats dy = hn::Sub(ty, hn::Set(d, balls.y[n]));
      const Floats dz = hn::Sub(tz, hn::Set(d, balls.z[n]));
      const Floats squared = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      sum = hn::Add(sum, spline(d, squared, hn::Set(d, balls.weight[n])));
    }
    hn::StoreU(sum, d, sums + t);
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::points
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::points {

HWY_EXPORT(balls_in_rows);
HWY_EXPORT(ellipsoids_in_rows);
HWY_EXPORT(balls_at_targets);

void add_balls(const BallBatch& balls, float step, float cut, float* values) {
  HWY_DYNAMIC_DISPATCH(balls_in_rows)(balls, step, cut, values);
}

void add_ellipsoids(const EllipsoidBatch& ellipsoids, float step, float cut, float* values) {
  HWY_DYNAMIC_DISPATCH(ellipsoids_in_rows)(ellipsoids, step, cut, values);
}

void add_at_targets(const BallBatch& balls, const float* x, const float* y, const float* z, std::size_t count,
                    float* sums) {
  HWY_DYNAMIC_DISPATCH(balls_at_targets)(balls, x, y, z, count, sums);
}

}  // namespace isoextract::points
#endif

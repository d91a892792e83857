#include "points/detail/spline_sums.hpp"

#include <bit>
#include <cstdint>

#include "base/simd_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "points/detail/spline_sums.cpp"  // Highway includes this file once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::points {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Rows and targets have lengths that are multiples of 8.
using Lanes = hn::CappedTag<float, 8>;
using Floats = hn::Vec<Lanes>;

// Returns weight * S(q) from q^2, as spline_shape() does.
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
  alignas(64) float y_squared[8];
  alignas(64) float from_rows[8];
  const Floats limit = hn::Set(d, cut_squared);
  const Floats one = hn::Set(d, 1);
  for (std::size_t n = 0; n < balls.size; ++n) {
    const Floats z = hn::Set(d, balls.z[n]);
    Floats nearest = hn::Set(d, 1);
    for (std::size_t k = 0; k < 8; k += lanes) {
      const Floats away = hn::Sub(hn::Load(d, at + k), z);
      const Floats squared = hn::Mul(away, away);
      hn::Store(squared, d, z_squared + k);
      nearest = hn::Min(nearest, squared);
    }
    // Skips rows whose nearest sample is at distance 1 or more, where the kernel is 0.
    const Floats least_z_squared = hn::MinOfLanes(d, nearest);
    for (int j = 0; j < 8; ++j) y_squared[j] = (at[j] - balls.y[n]) * (at[j] - balls.y[n]);
    const Floats weight = hn::Set(d, balls.weight[n]);
    for (int i = 0; i < 8; ++i) {
      const float x_squared = (at[i] - balls.x[n]) * (at[i] - balls.x[n]);
      if (x_squared >= cut_squared) continue;
      std::uint32_t rows = 0;  // a bit for each row that is near enough
      for (std::size_t j = 0; j < 8; j += lanes) {
        const Floats squared = hn::Add(hn::Set(d, x_squared), hn::Load(d, y_squared + j));
        hn::Store(squared, d, from_rows + j);
        std::uint8_t bits[8] = {};
        const Floats least = hn::Add(squared, least_z_squared);
        hn::StoreMaskBits(d, hn::And(hn::Lt(squared, limit), hn::Lt(least, one)), bits);
        rows |= static_cast<std::uint32_t>(bits[0]) << j;
      }
      for (; rows != 0; rows &= rows - 1) {
        const int j = std::countr_zero(rows);
        const Floats row = hn::Set(d, from_rows[j]);
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
  const Floats zero = hn::Zero(d);
  const float cut_squared = cut * cut;
  alignas(64) float at[8];
  for (int i = 0; i < 8; ++i) at[i] = step * static_cast<float>(i);
  // Along a row of samples the quadratic form is constant + linear * z + zz * z^2. Its minimum decides whether the row
  // is skipped. Minima of eight rows are computed together.
  alignas(64) float constants[8];
  alignas(64) float linears[8];
  alignas(64) float least[8];
  for (std::size_t n = 0; n < ellipsoids.size; ++n) {
    const Floats zz = hn::Set(d, ellipsoids.zz[n]);
    const Floats over_four_zz = hn::Set(d, 1 / (4 * ellipsoids.zz[n]));
    const Floats weight = hn::Set(d, ellipsoids.weight[n]);
    const Floats z = hn::Set(d, ellipsoids.z[n]);
    for (int i = 0; i < 8; ++i) {
      const float x = at[i] - ellipsoids.x[n];
      const Floats from_x = hn::Set(d, ellipsoids.xx[n] * x * x);
      const Floats with_x = hn::Set(d, 2 * ellipsoids.xy[n] * x);
      const Floats slope_of_x = hn::Set(d, 2 * ellipsoids.xz[n] * x);
      for (std::size_t j = 0; j < 8; j += lanes) {
        const Floats y = hn::Sub(hn::Load(d, at + j), hn::Set(d, ellipsoids.y[n]));
        const Floats linear = hn::Add(slope_of_x, hn::Mul(hn::Set(d, 2 * ellipsoids.yz[n]), y));
        const Floats from_y = hn::Mul(y, hn::Add(with_x, hn::Mul(hn::Set(d, ellipsoids.yy[n]), y)));
        const Floats constant = hn::Add(from_x, from_y);
        hn::Store(linear, d, linears + j);
        hn::Store(constant, d, constants + j);
        hn::Store(hn::Sub(constant, hn::Mul(hn::Mul(linear, linear), over_four_zz)), d, least + j);
      }
      for (int j = 0; j < 8; ++j) {
        if (least[j] >= cut_squared) continue;
        float* const sums = values + 64 * i + 8 * j;
        for (std::size_t k = 0; k < 8; k += lanes) {
          const Floats away = hn::Sub(hn::Load(d, at + k), z);
          const Floats slope = hn::Add(hn::Set(d, linears[j]), hn::Mul(zz, away));
          const Floats squared = hn::Max(zero, hn::Add(hn::Set(d, constants[j]), hn::Mul(away, slope)));
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

void moments_at_targets(const BallBatch& points, const float* x, const float* y, const float* z, std::size_t count,
                        Moments& moments) {
  const Lanes d;
  const Floats zero = hn::Zero(d);
  const Floats one = hn::Set(d, 1);
  for (std::size_t t = 0; t < count; t += hn::Lanes(d)) {
    const Floats tx = hn::LoadU(d, x + t);
    const Floats ty = hn::LoadU(d, y + t);
    const Floats tz = hn::LoadU(d, z + t);
    const auto load = [&](std::size_t m) { return hn::Load(d, moments.sums[m].data() + t); };
    Floats members = load(Moments::kPoints);
    Floats total = load(Moments::kTotal);
    Floats mx = load(Moments::kX);
    Floats my = load(Moments::kY);
    Floats mz = load(Moments::kZ);
    Floats xx = load(Moments::kXX);
    Floats xy = load(Moments::kXY);
    Floats xz = load(Moments::kXZ);
    Floats yy = load(Moments::kYY);
    Floats yz = load(Moments::kYZ);
    Floats zz = load(Moments::kZZ);
    for (std::size_t n = 0; n < points.size; ++n) {
      const Floats dx = hn::Sub(hn::Set(d, points.x[n]), tx);
      const Floats dy = hn::Sub(hn::Set(d, points.y[n]), ty);
      const Floats dz = hn::Sub(hn::Set(d, points.z[n]), tz);
      const Floats squared = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
      const Floats counted = hn::Set(d, points.weight[n]);
      members = hn::Add(members, hn::IfThenElseZero(hn::Lt(squared, one), counted));
      const Floats fall = hn::Sub(one, hn::Mul(squared, hn::Sqrt(squared)));
      const Floats w = hn::Mul(counted, hn::Max(zero, fall));
      total = hn::Add(total, w);
      const Floats wx = hn::Mul(w, dx);
      const Floats wy = hn::Mul(w, dy);
      const Floats wz = hn::Mul(w, dz);
      mx = hn::Add(mx, wx);
      my = hn::Add(my, wy);
      mz = hn::Add(mz, wz);
      xx = hn::Add(xx, hn::Mul(wx, dx));
      xy = hn::Add(xy, hn::Mul(wx, dy));
      xz = hn::Add(xz, hn::Mul(wx, dz));
      yy = hn::Add(yy, hn::Mul(wy, dy));
      yz = hn::Add(yz, hn::Mul(wy, dz));
      zz = hn::Add(zz, hn::Mul(wz, dz));
    }
    const auto store = [&](Floats v, std::size_t m) { hn::Store(v, d, moments.sums[m].data() + t); };
    store(members, Moments::kPoints);
    store(total, Moments::kTotal);
    store(mx, Moments::kX);
    store(my, Moments::kY);
    store(mz, Moments::kZ);
    store(xx, Moments::kXX);
    store(xy, Moments::kXY);
    store(xz, Moments::kXZ);
    store(yy, Moments::kYY);
    store(yz, Moments::kYZ);
    store(zz, Moments::kZZ);
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
HWY_EXPORT(moments_at_targets);

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

void add_moments(const BallBatch& points, const float* x, const float* y, const float* z, std::size_t count,
                 Moments& moments) {
  HWY_DYNAMIC_DISPATCH(moments_at_targets)(points, x, y, z, count, moments);
}

}  // namespace isoextract::points
#endif

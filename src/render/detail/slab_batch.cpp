#include "render/detail/slab_batch.hpp"

#include <algorithm>

#include "base/simd_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/detail/slab_batch.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::render::detail {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t kSlabs = SlabBatch::kSlabs;

// Batches are padded to multiples of eight.
using Doubles = hn::CappedTag<double, 8>;
using Floats = hn::CappedTag<float, 8>;
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfInts = hn::Rebind<std::int32_t, Doubles>;
using Channels = hn::CappedTag<float, 4>;
using DoubleVec = hn::Vec<Doubles>;

// Returns the padded number of slabs; padding repeats the last slab.
HWY_INLINE std::size_t pad(SlabBatch& batch) {
  const std::size_t padded = (batch.size + 7) / 8 * 8;
  for (std::size_t i = batch.size; i < padded; ++i) batch.number[i] = batch.number[batch.size - 1];
  return padded;
}

void place_slabs(const SlabRay& ray, SlabBatch& batch) {
  const Doubles d;
  const std::size_t count = pad(batch);
  const DoubleVec enter = hn::Set(d, ray.enter);
  const DoubleVec leave = hn::Set(d, ray.leave);
  const DoubleVec step = hn::Set(d, ray.step);
  const DoubleVec slabs = hn::Set(d, ray.slabs);
  const DoubleVec one = hn::Set(d, 1.0);
  const DoubleVec half = hn::Set(d, 0.5);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const DoubleVec k = hn::Load(d, batch.number.data() + i);
    const DoubleVec next = hn::Add(k, one);
    const DoubleVec first = hn::Add(enter, hn::Mul(k, step));
    const DoubleVec last = hn::IfThenElse(hn::Lt(next, slabs), hn::Add(enter, hn::Mul(next, step)), leave);
    const DoubleVec middle = hn::Add(first, hn::Mul(hn::Sub(last, first), half));
    hn::Store(first, d, batch.first.data() + i);
    hn::Store(last, d, batch.last.data() + i);
    for (int axis = 0; axis < 3; ++axis) {
      const DoubleVec index = hn::Add(hn::Set(d, ray.eye[axis]), hn::Mul(middle, hn::Set(d, ray.along[axis])));
      const DoubleVec cell =
          hn::Min(hn::Max(hn::Floor(index), hn::Set(d, ray.first[axis])), hn::Set(d, ray.greatest[axis]));
      const auto of_axis = static_cast<std::size_t>(axis);
      hn::Store(hn::DemoteTo(HalfInts(), cell), HalfInts(), batch.cell[of_axis].data() + i);
      hn::Store(hn::DemoteTo(HalfFloats(), hn::Sub(index, cell)), HalfFloats(), batch.share[of_axis].data() + i);
    }
  }
}

// Computes table positions of stored values; NaN stays NaN.
template <class Raw>
HWY_INLINE void positions_of(const PositionScale& scale, const CornerSamples<Raw>& corners, std::size_t count,
                             std::array<std::array<float, kSlabs>, 8>& positions) {
  const Doubles d;
  const hn::Rebind<Raw, Doubles> raw;
  const DoubleVec min = hn::Set(d, scale.min);
  const DoubleVec positions_per_value = hn::Set(d, scale.positions_per_value);
  const DoubleVec slope = hn::Set(d, scale.slope);
  const DoubleVec intercept = hn::Set(d, scale.intercept);
  const DoubleVec farthest = hn::Set(d, TransferFunction::kFarthest);
  const DoubleVec nearest = hn::Set(d, -TransferFunction::kFarthest);
  for (std::size_t n = 0; n < 8; ++n) {
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      DoubleVec value;
      if constexpr (sizeof(Raw) == sizeof(double)) {
        value = hn::Load(d, corners.at[n].data() + i);
      } else {
        value = hn::PromoteTo(d, hn::Load(raw, corners.at[n].data() + i));
      }
      if (scale.scaled) value = hn::Add(hn::Mul(slope, value), intercept);
      DoubleVec position = hn::Mul(hn::Sub(value, min), positions_per_value);
      position = hn::IfThenElse(hn::Lt(position, nearest), nearest, position);
      position = hn::IfThenElse(hn::Lt(farthest, position), farthest, position);
      hn::Store(hn::DemoteTo(HalfFloats(), position), HalfFloats(), positions[n].data() + i);
    }
  }
}

HWY_INLINE hn::Vec<Floats> between(hn::Vec<Floats> a, hn::Vec<Floats> b, hn::Vec<Floats> share) {
  return hn::Add(a, hn::Mul(share, hn::Sub(b, a)));
}

// Computes TransferFunction::lookup() of the trilinear interpolant.
HWY_INLINE void look_up(const std::array<std::array<float, kSlabs>, 8>& positions, const TransferFunction& transfer,
                        std::size_t count, SlabBatch& batch) {
  constexpr int kLast = TransferFunction::kEntries - 1;
  const Floats d;
  const hn::Rebind<std::int32_t, Floats> ints;
  alignas(64) std::array<std::int32_t, kSlabs> below;
  alignas(64) std::array<float, kSlabs> rest;
  alignas(64) std::array<float, kSlabs> known;  // 1, or 0 for NaN
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto at = [&](std::size_t n) { return hn::Load(d, positions[n].data() + i); };
    const auto x = hn::Load(d, batch.share[0].data() + i);
    const auto y = hn::Load(d, batch.share[1].data() + i);
    const auto z = hn::Load(d, batch.share[2].data() + i);
    const auto low = between(between(at(0), at(1), x), between(at(2), at(3), x), y);
    const auto high = between(between(at(4), at(5), x), between(at(6), at(7), x), y);
    const auto position = between(low, high, z);
    const auto number = hn::Eq(position, position);
    const auto in_table = hn::Min(hn::Max(hn::IfThenElseZero(number, position), hn::Zero(d)), hn::Set(d, float{kLast}));
    const auto entry = hn::ConvertTo(ints, in_table);
    hn::Store(entry, ints, below.data() + i);
    hn::Store(hn::Sub(in_table, hn::ConvertTo(d, entry)), d, rest.data() + i);
    hn::Store(hn::IfThenElseZero(number, hn::Set(d, 1.0F)), d, known.data() + i);
  }
  const Channels channels;
  const glm::vec4* const table = transfer.table().data();
  for (std::size_t i = 0; i < count; ++i) {
    const float* const a = &table[below[i]].x;
    const float* const b = &table[std::min(below[i] + 1, kLast)].x;
    float* const to = &batch.entry[i].x;
    const auto share = hn::Set(channels, rest[i]);
    for (std::size_t c = 0; c < 4; c += hn::Lanes(channels)) {
      const auto from = hn::LoadU(channels, a + c);
      hn::StoreU(hn::Add(from, hn::Mul(share, hn::Sub(hn::LoadU(channels, b + c), from))), channels, to + c);
    }
    batch.sigma[i] = known[i] * batch.entry[i].a;
  }
}

// Returns exp(-x) for x from 0 to 60: 2^n times the exponential series of the remainder, which is within +-ln(2)/2.
HWY_INLINE DoubleVec exp_of_negative(Doubles d, DoubleVec x) {
  constexpr double kPerOctave = 1.4426950408889634;
  constexpr double kOctaveHigh = 0x1.62e42feep-1;  // ln 2 as a sum of two numbers, the first with few digits
  constexpr double kOctaveLow = 0x1.a39ef35793c76p-33;
  constexpr double kRound = 0x1.8p52;  // adding it rounds to a whole number, held in the lowest bits
  constexpr std::array kSeries{
      1.0 / 479001600, 1.0 / 39916800, 1.0 / 3628800, 1.0 / 362880, 1.0 / 40320, 1.0 / 5040, 1.0 / 720,
      1.0 / 120,       1.0 / 24,       1.0 / 6,       0.5,          1.0,         1.0};
  const hn::Rebind<std::uint64_t, Doubles> bits;
  const DoubleVec shifted = hn::Add(hn::Mul(x, hn::Set(d, -kPerOctave)), hn::Set(d, kRound));
  const DoubleVec octaves = hn::Sub(shifted, hn::Set(d, kRound));
  DoubleVec rest = hn::Sub(hn::Neg(x), hn::Mul(octaves, hn::Set(d, kOctaveHigh)));
  rest = hn::Sub(rest, hn::Mul(octaves, hn::Set(d, kOctaveLow)));
  DoubleVec sum = hn::Set(d, kSeries[0]);
  for (std::size_t n = 1; n < kSeries.size(); ++n) sum = hn::Add(hn::Mul(sum, rest), hn::Set(d, kSeries[n]));
  return hn::BitCast(d, hn::Add(hn::BitCast(bits, sum), hn::ShiftLeft<52>(hn::BitCast(bits, shifted))));
}

HWY_INLINE void dim(const SlabRay& ray, std::size_t count, SlabBatch& batch) {
  const Doubles d;
  const DoubleVec one = hn::Set(d, 1.0);
  const DoubleVec most = hn::Set(d, 60.0);  // exp(-60) no longer changes a bit of 1
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const DoubleVec sigma = hn::PromoteTo(d, hn::Load(HalfFloats(), batch.sigma.data() + i));
    const DoubleVec per_depth = hn::Mul(hn::Mul(sigma, hn::Set(d, ray.length)), hn::Set(d, ray.per_length));
    const DoubleVec depth =
        hn::Mul(per_depth, hn::Sub(hn::Load(d, batch.last.data() + i), hn::Load(d, batch.first.data() + i)));
    const DoubleVec counted = hn::IfThenElse(hn::Lt(depth, most), depth, most);
    hn::Store(hn::Sub(one, exp_of_negative(d, counted)), d, batch.opacity.data() + i);
  }
}

template <class Raw>
HWY_INLINE void shade_slabs(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
                            const CornerSamples<Raw>& corners, SlabBatch& batch) {
  const std::size_t count = (batch.size + 7) / 8 * 8;
  alignas(64) std::array<std::array<float, kSlabs>, 8> positions;
  positions_of(scale, corners, count, positions);
  look_up(positions, transfer, count, batch);
  dim(ray, count, batch);
}

void shade_ints(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
                const CornerSamples<std::int32_t>& corners, SlabBatch& batch) {
  shade_slabs(ray, scale, transfer, corners, batch);
}
void shade_floats(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
                  const CornerSamples<float>& corners, SlabBatch& batch) {
  shade_slabs(ray, scale, transfer, corners, batch);
}
void shade_doubles(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
                   const CornerSamples<double>& corners, SlabBatch& batch) {
  shade_slabs(ray, scale, transfer, corners, batch);
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::render::detail
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::render::detail {

HWY_EXPORT(place_slabs);
HWY_EXPORT(shade_ints);
HWY_EXPORT(shade_floats);
HWY_EXPORT(shade_doubles);

void place(const SlabRay& ray, SlabBatch& batch) { HWY_DYNAMIC_DISPATCH(place_slabs)(ray, batch); }

void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<std::int32_t>& corners, SlabBatch& batch) {
  HWY_DYNAMIC_DISPATCH(shade_ints)(ray, scale, transfer, corners, batch);
}

void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<float>& corners, SlabBatch& batch) {
  HWY_DYNAMIC_DISPATCH(shade_floats)(ray, scale, transfer, corners, batch);
}

void shade(const SlabRay& ray, const PositionScale& scale, const TransferFunction& transfer,
           const CornerSamples<double>& corners, SlabBatch& batch) {
  HWY_DYNAMIC_DISPATCH(shade_doubles)(ray, scale, transfer, corners, batch);
}

}  // namespace isoextract::render::detail
#endif

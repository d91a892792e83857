#include "extract/detail/vertex_batch.hpp"

#include <algorithm>
#include <array>
#include <cstring>

#include "base/simd_targets.hpp"
#include "extract/row_bits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/detail/vertex_batch.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::extract {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Doubles = hn::ScalableTag<double>;
using Ints = hn::Rebind<std::int32_t, Doubles>;
using Floats = hn::Rebind<float, Doubles>;
using DoubleVec = hn::Vec<Doubles>;
constexpr Doubles kDoubles;
constexpr Ints kInts;
constexpr Floats kFloats;

struct Vec3 {
  DoubleVec x, y, z;
};

// One vector for each column of glm's matrix; additions are in the order of glm, so that results are equal.
struct Matrix {
  DoubleVec m[3][3];

  explicit Matrix(const glm::dmat3& from) {
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) m[c][r] = hn::Set(kDoubles, from[c][r]);
    }
  }
  HWY_INLINE DoubleVec row(const Vec3& v, int r) const {
    return hn::Add(hn::Add(hn::Mul(m[0][r], v.x), hn::Mul(m[1][r], v.y)), hn::Mul(m[2][r], v.z));
  }
  HWY_INLINE Vec3 operator*(const Vec3& v) const { return {row(v, 0), row(v, 1), row(v, 2)}; }
};

HWY_INLINE Vec3 operator*(DoubleVec s, const Vec3& v) { return {hn::Mul(s, v.x), hn::Mul(s, v.y), hn::Mul(s, v.z)}; }
HWY_INLINE Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}
HWY_INLINE Vec3 operator/(const Vec3& v, DoubleVec s) { return {hn::Div(v.x, s), hn::Div(v.y, s), hn::Div(v.z, s)}; }

// Stores the first `count` points of a vector.
HWY_INLINE void store_points(const Vec3& v, int count, glm::vec3* out) {
  const auto x = hn::DemoteTo(kFloats, v.x);
  const auto y = hn::DemoteTo(kFloats, v.y);
  const auto z = hn::DemoteTo(kFloats, v.z);
  const int lanes = static_cast<int>(hn::Lanes(kFloats));
  if (HWY_LIKELY(count >= lanes)) {
    hn::StoreInterleaved3(x, y, z, kFloats, &out->x);
  } else {
    float points[3 * hn::MaxLanes(kFloats)];
    hn::StoreInterleaved3(x, y, z, kFloats, points);
    std::memcpy(static_cast<void*>(out), points, sizeof(glm::vec3) * static_cast<std::size_t>(count));
  }
}

HWY_INLINE DoubleVec load_axis(const std::int32_t* from) { return hn::PromoteTo(kDoubles, hn::LoadU(kInts, from)); }

// Writes the vertices of the batch. Sets a bit in `left` for each vertex with a number that is not finite or, with
// normals, a zero gradient; the caller must write these vertices again.
template <bool kNormals>
void place_batch(const VertexBatch& batch, const VertexRules& rules, glm::vec3* positions, glm::vec3* normals,
                 std::uint64_t* left) {
  const int lanes = static_cast<int>(hn::Lanes(kDoubles));
  const OutputPlacement& placement = rules.placement;
  const Matrix linear(placement.local_from_index().linear);
  const Matrix covectors(placement.covector_map());
  const glm::dvec3& shift = placement.local_from_index().offset;
  const Vec3 offset{hn::Set(kDoubles, shift.x), hn::Set(kDoubles, shift.y), hn::Set(kDoubles, shift.z)};
  const auto outward = hn::Set(kDoubles, placement.outward());
  const auto iso = hn::Set(kDoubles, rules.inside.iso);
  const auto low = hn::Set(kDoubles, placement.margin());
  const auto high = hn::Set(kDoubles, 1 - placement.margin());
  const auto slope = hn::Set(kDoubles, rules.scale.slope);
  const auto intercept = hn::Set(kDoubles, rules.scale.intercept);
  const bool scaled = !rules.scale.is_identity();
  const auto one_int = hn::Set(kInts, 1);
  const auto one = hn::Set(kDoubles, 1.0);
  for (int i = 0; i < batch.count; i += lanes) {
    const int count = std::min(lanes, batch.count - i);
    auto f0 = hn::LoadU(kDoubles, batch.value[0] + i);
    auto f1 = hn::LoadU(kDoubles, batch.value[1] + i);
    if (scaled) {
      f0 = hn::Add(hn::Mul(slope, f0), intercept);
      f1 = hn::Add(hn::Mul(slope, f1), intercept);
    }
    const auto change = hn::Sub(f1, f0);
    auto good = hn::IsFinite(change);
    const auto t = hn::Min(hn::Max(hn::Div(hn::Sub(iso, f0), change), low), high);

    const auto direction = hn::LoadU(kInts, batch.direction + i);
    const Vec3 step{hn::PromoteTo(kDoubles, hn::And(direction, one_int)),
                    hn::PromoteTo(kDoubles, hn::And(hn::ShiftRight<1>(direction), one_int)),
                    hn::PromoteTo(kDoubles, hn::And(hn::ShiftRight<2>(direction), one_int))};
    const Vec3 from{load_axis(batch.low[0] + i), load_axis(batch.low[1] + i), load_axis(batch.low[2] + i)};
    store_points(linear * (from + t * step) + offset, count, positions + i);

    if constexpr (kNormals) {
      const auto load = [&](int end) HWY_ATTR -> Vec3 {
        return {hn::LoadU(kDoubles, batch.gradient[end][0] + i), hn::LoadU(kDoubles, batch.gradient[end][1] + i),
                hn::LoadU(kDoubles, batch.gradient[end][2] + i)};
      };
      const Vec3 mapped = covectors * (outward * (hn::Sub(one, t) * load(0) + t * load(1)));
      const auto largest = hn::Max(hn::Max(hn::Abs(mapped.x), hn::Abs(mapped.y)), hn::Abs(mapped.z));
      // A finite sum means that all parts are finite. The other vertices are checked one at a time.
      const auto sum = hn::Add(hn::Add(hn::Abs(mapped.x), hn::Abs(mapped.y)), hn::Abs(mapped.z));
      good = hn::And(good, hn::And(hn::IsFinite(sum), hn::Gt(largest, hn::Zero(kDoubles))));
      const Vec3 unit = mapped / largest;
      const auto length =
          hn::Sqrt(hn::Add(hn::Add(hn::Mul(unit.x, unit.x), hn::Mul(unit.y, unit.y)), hn::Mul(unit.z, unit.z)));
      store_points(unit / length, count, normals + i);
    }
    if (HWY_UNLIKELY(!hn::AllTrue(kDoubles, good))) {
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(kDoubles, hn::Not(good), bits);
      left[i / 64] |= static_cast<std::uint64_t>(bits[0] & ((1U << count) - 1)) << (i % 64);
    }
  }
}

void place_any(const VertexBatch& batch, const VertexRules& rules, glm::vec3* positions, glm::vec3* normals,
               std::uint64_t* left) {
  (normals != nullptr ? place_batch<true> : place_batch<false>)(batch, rules, positions, normals, left);
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::extract
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::extract {

HWY_EXPORT(place_any);

namespace {

void place_plainly(const VertexBatch& batch, int i, const VertexRules& rules, glm::vec3& position, glm::vec3* normal) {
  const glm::dvec3 low(batch.low[0][i], batch.low[1][i], batch.low[2][i]);
  const glm::dvec3 step = direction_step(batch.direction[i]);
  const double f0 = rules.scale(batch.value[0][i]);
  const double t = edge_crossing(f0, rules.scale(batch.value[1][i]), rules.inside.iso, rules.placement.margin());
  position = rules.placement.position(low + t * step);
  if (normal == nullptr) return;
  const auto gradient = [&](int end) {
    return glm::dvec3(batch.gradient[end][0][i], batch.gradient[end][1][i], batch.gradient[end][2][i]);
  };
  const glm::dvec3 out = (rules.inside(f0) ? 1.0 : -1.0) * step;
  // A vertex next to a NaN sample is in the middle of the edge, so the gradient says nothing about the normal there.
  const bool beside_nan = std::isnan(batch.value[0][i]) || std::isnan(batch.value[1][i]);
  if (beside_nan || glm::any(glm::isnan(gradient(0))) || glm::any(glm::isnan(gradient(1)))) {
    *normal = rules.placement.placeholder_normal(out);
  } else {
    *normal = rules.placement.normal((1 - t) * gradient(0) + t * gradient(1), out);
  }
}

}  // namespace

void write_vertices(VertexBatch& batch, const VertexRules& rules, mesh::Mesh& mesh, std::size_t first) {
  glm::vec3* positions = mesh.positions.data() + first;
  glm::vec3* normals = mesh.normals.empty() ? nullptr : mesh.normals.data() + first;
  std::array<std::uint64_t, VertexBatch::kCapacity / 64> left{};
  HWY_DYNAMIC_DISPATCH(place_any)(batch, rules, positions, normals, left.data());
  for (std::size_t w = 0; w < left.size(); ++w) {
    for_each_bit(left[w], [&](int bit) {
      const int i = static_cast<int>(64 * w) + bit;
      place_plainly(batch, i, rules, positions[i], normals == nullptr ? nullptr : normals + i);
    });
  }
  if (!mesh.edges.empty()) {
    for (int i = 0; i < batch.count; ++i) {
      mesh.edges[first + static_cast<std::size_t>(i)] = {{batch.low[0][i], batch.low[1][i], batch.low[2][i]},
                                                         batch.direction[i]};
    }
  }
  batch.count = 0;
}

}  // namespace isoextract::extract
#endif

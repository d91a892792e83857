#include "extract/detail/classify_samples.hpp"

#include <algorithm>

#include "base/simd_targets.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/detail/classify_samples.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::extract {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// Types whose numbers are compared directly.
template <class T>
struct Lane {
  using Type = T;
  static const T* samples(const T* p) { return p; }
  template <class D, class V>
  static HWY_INLINE V comparable(D, V v) {
    return v;
  }
  template <class D, class V>
  static HWY_INLINE hn::Mask<D> nan(D d, V v) {
    if constexpr (std::is_floating_point_v<T>) return hn::IsNaN(v);
    return hn::FirstN(d, 0);
  }
};

// Halves are compared as ordered integers.
template <>
struct Lane<field::Half> {
  using Type = std::uint16_t;
  static const std::uint16_t* samples(const field::Half* p) { return reinterpret_cast<const std::uint16_t*>(p); }
  template <class D, class V>
  static HWY_INLINE V comparable(D d, V v) {
    const hn::RebindToSigned<D> ds;
    const V sign = hn::BitCast(d, hn::ShiftRight<15>(hn::BitCast(ds, v)));
    return hn::Xor(v, hn::Or(sign, hn::Set(d, 0x8000)));
  }
  template <class D, class V>
  static HWY_INLINE hn::Mask<D> nan(D d, V v) {
    const hn::RebindToSigned<D> ds;
    const V magnitude = hn::And(v, hn::Set(d, 0x7FFF));
    return hn::MaskFromVec(
        hn::BitCast(d, hn::VecFromMask(ds, hn::Gt(hn::BitCast(ds, magnitude), hn::Set(ds, 0x7C00)))));
  }
};

// Returns the inside samples of a vector. For integers "not less" means "at least".
template <class T, bool kAbove, class D, class V>
HWY_INLINE hn::Mask<D> inside(D d, V raw, V threshold) {
  const V v = Lane<T>::comparable(d, raw);
  if constexpr (std::is_floating_point_v<T>) {
    return kAbove ? hn::Ge(v, threshold) : hn::Le(v, threshold);
  } else {
    const auto in = hn::Not(kAbove ? hn::Lt(v, threshold) : hn::Gt(v, threshold));
    if constexpr (std::is_same_v<T, field::Half>) return hn::AndNot(Lane<T>::nan(d, raw), in);
    return in;
  }
}

template <class T, bool kAbove>
std::uint64_t classify_words(const T* samples, std::size_t words, typename Lane<T>::Type threshold,
                             std::uint64_t* bits) {
  using L = Lane<T>;
  const hn::ScalableTag<typename L::Type> d;
  const std::size_t lanes = hn::Lanes(d);
  const auto limit = hn::Set(d, threshold);
  const auto* from = L::samples(samples);
  std::uint64_t nan_count = 0;
  for (std::size_t w = 0; w < words; ++w, from += 64) {
    auto nan = hn::FirstN(d, 0);
    if (lanes >= 8) {
      auto* out = reinterpret_cast<std::uint8_t*>(bits + w);
      for (std::size_t at = 0; at < 64; at += lanes) {
        const auto v = hn::LoadU(d, from + at);
        hn::StoreMaskBits(d, inside<T, kAbove>(d, v, limit), out + at / 8);
        if constexpr (field::is_floating_sample<T>) nan = hn::Or(nan, L::nan(d, v));
      }
    } else {
      std::uint64_t word = 0;
      for (std::size_t at = 0; at < 64; at += lanes) {
        const auto v = hn::LoadU(d, from + at);
        std::uint8_t byte[8];
        hn::StoreMaskBits(d, inside<T, kAbove>(d, v, limit), byte);
        word |= static_cast<std::uint64_t>(byte[0]) << at;
        if constexpr (field::is_floating_sample<T>) nan = hn::Or(nan, L::nan(d, v));
      }
      bits[w] = word;
    }
    if constexpr (field::is_floating_sample<T>) {
      if (HWY_LIKELY(hn::AllFalse(d, nan))) continue;
      for (std::size_t at = 0; at < 64; at += lanes) {
        nan_count += hn::CountTrue(d, L::nan(d, hn::LoadU(d, from + at)));
      }
    }
  }
  return nan_count;
}

// `threshold` points to a number of the type, or to the ordered key of a half.
std::uint64_t classify_typed(field::SampleType type, const void* samples, std::size_t words, const void* threshold,
                             bool above, std::uint64_t* bits) {
  return visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
    const auto limit = *static_cast<const typename Lane<T>::Type*>(threshold);
    const auto* typed = static_cast<const T*>(samples);
    return above ? classify_words<T, true>(typed, words, limit, bits)
                 : classify_words<T, false>(typed, words, limit, bits);
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::extract
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::extract {

static_assert(std::endian::native == std::endian::little, "the masks store bits in little-endian bytes");

HWY_EXPORT(classify_typed);

template <class T>
std::uint64_t classify_samples(const T* samples, std::size_t count, const InsideThreshold<T>& threshold,
                               std::uint64_t* bits) {
  const InsideClassifier<T> plain(threshold);
  const auto limit = plain.threshold();
  const std::size_t words = count / 64;
  std::uint64_t nan =
      HWY_DYNAMIC_DISPATCH(classify_typed)(field::sample_type_of<T>(), samples, words, &limit, threshold.above, bits);
  if (count % 64 != 0) bits[words] = plain(samples + 64 * words, static_cast<int>(count % 64), nan);
  return nan;
}

#define ISOEXTRACT_INSTANTIATE(T) \
  template std::uint64_t classify_samples(const T*, std::size_t, const InsideThreshold<T>&, std::uint64_t*);
ISOEXTRACT_EACH_SAMPLE_TYPE(ISOEXTRACT_INSTANTIATE)
#undef ISOEXTRACT_INSTANTIATE

}  // namespace isoextract::extract
#endif

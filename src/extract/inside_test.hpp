// Decides which stored samples are inside, with one comparison in the stored type.
//
// "value(stored) > iso" (density) and "value(stored) < iso" (level set) are monotone in the stored number, also after
// rounding, because value = slope * stored + intercept is. So the inside numbers are all numbers above (or below) a
// threshold. Bisection over the ordered numbers of the type finds it once, exactly. Integers wider than float, doubles
// at large offsets and scaled integers are thus classified without rounding.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>

#include "field/scalar_field.hpp"

namespace isoextract::extract {

// Maps the numbers of T to unsigned integers of the same order; floats from -infinity to +infinity, without NaN.
template <class T>
struct OrderedKey {
  using Key = std::make_unsigned_t<T>;
  static constexpr Key kFlip = std::is_signed_v<T> ? Key{1} << (8 * sizeof(T) - 1) : Key{0};
  static constexpr Key kLowest = 0;
  static constexpr Key kHighest = static_cast<Key>(-1);

  static T value(Key key) { return static_cast<T>(static_cast<Key>(key ^ kFlip)); }
  static Key key(T value) { return static_cast<Key>(static_cast<Key>(value) ^ kFlip); }
};

template <class Bits>
struct OrderedFloatBits {
  static constexpr Bits kSign = static_cast<Bits>(Bits{1} << (8 * sizeof(Bits) - 1));
  static constexpr Bits key(Bits bits) { return static_cast<Bits>((bits & kSign) != 0 ? ~bits : (bits | kSign)); }
  static constexpr Bits bits(Bits key) { return static_cast<Bits>((key & kSign) != 0 ? (key & ~kSign) : ~key); }
};

template <class T, class Bits, Bits kInfinity>
struct OrderedFloat {
  using Key = Bits;
  static constexpr Key kLowest = OrderedFloatBits<Bits>::key(OrderedFloatBits<Bits>::kSign | kInfinity);
  static constexpr Key kHighest = OrderedFloatBits<Bits>::key(kInfinity);
  static T value(Key key) { return std::bit_cast<T>(OrderedFloatBits<Bits>::bits(key)); }
  static Key key(T value) { return OrderedFloatBits<Bits>::key(std::bit_cast<Bits>(value)); }
};

template <>
struct OrderedKey<float> : OrderedFloat<float, std::uint32_t, 0x7F800000U> {};
template <>
struct OrderedKey<double> : OrderedFloat<double, std::uint64_t, 0x7FF0000000000000ULL> {};
template <>
struct OrderedKey<field::Half> : OrderedFloat<field::Half, std::uint16_t, 0x7C00U> {};

// The rule for one value of the field (after its scale). NaN is outside.
struct InsideRule {
  field::FieldKind kind;
  double iso;
  bool operator()(double value) const { return kind == field::FieldKind::density ? value > iso : value < iso; }

  // Returns how far a value is inside (negative: outside). Uses long double, so that no difference of finite values
  // underflows to zero or overflows.
  [[nodiscard]] long double depth(double value) const {
    const long double above = static_cast<long double>(value) - static_cast<long double>(iso);
    return kind == field::FieldKind::density ? above : -above;
  }
};

template <class T>
struct InsideThreshold {
  T threshold;  // the lowest inside number if `above`, else the highest
  bool above;   // inside is stored >= threshold, otherwise stored <= threshold
};

// Returns the threshold for stored samples of type T, or nullopt if no number of T is inside.
template <class T>
std::optional<InsideThreshold<T>> find_inside_threshold(const InsideRule& rule, const field::ValueScale& scale) {
  using Order = OrderedKey<T>;
  using Key = typename Order::Key;
  const auto inside = [&](Key key) { return rule(scale(static_cast<double>(Order::value(key)))); };
  const bool above = (rule.kind == field::FieldKind::density) == (scale.slope > 0);
  // `in` is always an inside key, `out` an outside one, until they are adjacent.
  Key in = above ? Order::kHighest : Order::kLowest;
  Key out = above ? Order::kLowest : Order::kHighest;
  if (!inside(in)) return std::nullopt;
  if (inside(out)) return InsideThreshold<T>{Order::value(out), above};
  while ((in > out ? in - out : out - in) > 1) {
    const auto middle = static_cast<Key>(std::min(in, out) + (std::max(in, out) - std::min(in, out)) / 2);
    (inside(middle) ? in : out) = middle;
  }
  return InsideThreshold<T>{Order::value(in), above};
}

// Compares up to 64 samples. Bit b of the result is set if sample b is inside. Adds the number of NaN samples to `nan`.
template <class T>
class InsideClassifier {
 public:
  explicit InsideClassifier(const InsideThreshold<T>& threshold)
      : threshold_(comparable(threshold.threshold)), above_(threshold.above) {}

  // Returns the threshold in the form used for comparison: the number itself, or the ordered key of a half.
  [[nodiscard]] auto threshold() const { return threshold_; }

  std::uint64_t operator()(const T* samples, int count, std::uint64_t& nan) const {
    return above_ ? compare<true>(samples, count, nan) : compare<false>(samples, count, nan);
  }

 private:
  // Halves are compared as ordered integers.
  static auto comparable(T sample) {
    if constexpr (std::is_same_v<T, field::Half>) {
      return OrderedFloatBits<std::uint16_t>::key(sample.bits());
    } else {
      return sample;
    }
  }
  static bool is_nan(T sample) {
    if constexpr (std::is_same_v<T, field::Half>) return (sample.bits() & 0x7FFF) > 0x7C00;
    if constexpr (std::is_floating_point_v<T>) return sample != sample;
    return false;
  }

  template <bool kAbove>
  std::uint64_t compare(const T* samples, int count, std::uint64_t& nan) const {
    // The first loop writes one byte a sample, which compilers can vectorize. A multiplication then packs eight bytes
    // into eight bits.
    std::uint8_t flags[64] = {};
    unsigned found_nan = 0;
    for (int b = 0; b < count; ++b) {
      bool in = kAbove ? comparable(samples[b]) >= threshold_ : comparable(samples[b]) <= threshold_;
      if constexpr (field::is_floating_sample<T>) found_nan += is_nan(samples[b]) ? 1U : 0U;
      if constexpr (std::is_same_v<T, field::Half>) in = in && !is_nan(samples[b]);
      flags[b] = in ? 1 : 0;
    }
    nan += found_nan;
    std::uint64_t word = 0;
    for (int byte = 0; byte < 8; ++byte) {
      std::uint64_t eight = 0;
      std::memcpy(&eight, flags + 8 * byte, 8);
      word |= (eight * 0x0102040810204080ULL >> 56) << (8 * byte);
    }
    return word;
  }

  decltype(comparable(T{})) threshold_;
  bool above_;
};

// The sides on which the outermost samples of a box lie.
struct BoundarySides {
  bool inside = false;
  bool outside = false;
};

}  // namespace isoextract::extract

// The storage types of samples. Fields keep the type of their file; code converts values where it uses them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include <half.h>  // Imath

#include "base/enum_words.hpp"

namespace isoextract::field {

enum class SampleType { u8, i8, u16, i16, u32, i32, f16, f32, f64 };
constexpr auto words_of(SampleType /*type*/) {
  return std::array{Word{SampleType::u8, "u8"},   Word{SampleType::i8, "i8"},   Word{SampleType::u16, "u16"},
                    Word{SampleType::i16, "i16"}, Word{SampleType::u32, "u32"}, Word{SampleType::i32, "i32"},
                    Word{SampleType::f16, "f16"}, Word{SampleType::f32, "f32"}, Word{SampleType::f64, "f64"}};
}

using Half = Imath::half;

// Calls f(std::type_identity<T>{}) with the C++ type of `type`.
template <class F>
decltype(auto) visit_sample_type(SampleType type, F&& f) {
  switch (type) {
    case SampleType::u8: return f(std::type_identity<std::uint8_t>{});
    case SampleType::i8: return f(std::type_identity<std::int8_t>{});
    case SampleType::u16: return f(std::type_identity<std::uint16_t>{});
    case SampleType::i16: return f(std::type_identity<std::int16_t>{});
    case SampleType::u32: return f(std::type_identity<std::uint32_t>{});
    case SampleType::i32: return f(std::type_identity<std::int32_t>{});
    case SampleType::f16: return f(std::type_identity<Half>{});
    case SampleType::f32: return f(std::type_identity<float>{});
    case SampleType::f64: break;
  }
  return f(std::type_identity<double>{});
}

template <class T>
inline constexpr bool is_floating_sample = std::is_floating_point_v<T> || std::is_same_v<T, Half>;

[[nodiscard]] std::size_t sample_size(SampleType type);

// "u8", "i16", "f32", ...
[[nodiscard]] constexpr std::string_view sample_type_name(SampleType type) { return word_of(type); }

// Returns the SampleType that a C++ type corresponds to.
template <class T>
[[nodiscard]] constexpr SampleType sample_type_of() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return SampleType::u8;
  if constexpr (std::is_same_v<T, std::int8_t>) return SampleType::i8;
  if constexpr (std::is_same_v<T, std::uint16_t>) return SampleType::u16;
  if constexpr (std::is_same_v<T, std::int16_t>) return SampleType::i16;
  if constexpr (std::is_same_v<T, std::uint32_t>) return SampleType::u32;
  if constexpr (std::is_same_v<T, std::int32_t>) return SampleType::i32;
  if constexpr (std::is_same_v<T, Half>) return SampleType::f16;
  if constexpr (std::is_same_v<T, float>) return SampleType::f32;
  if constexpr (std::is_same_v<T, double>) return SampleType::f64;
}

}  // namespace isoextract::field

// Number types of binary particle files.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "field/sample_type.hpp"

namespace isoextract::particle_io {

enum class NumberType { u8, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 };

// Calls f(std::type_identity<T>{}) with the C++ type of `type`.
template <class F>
decltype(auto) visit_number_type(NumberType type, F&& f) {
  switch (type) {
    case NumberType::u8: return f(std::type_identity<std::uint8_t>{});
    case NumberType::i8: return f(std::type_identity<std::int8_t>{});
    case NumberType::u16: return f(std::type_identity<std::uint16_t>{});
    case NumberType::i16: return f(std::type_identity<std::int16_t>{});
    case NumberType::u32: return f(std::type_identity<std::uint32_t>{});
    case NumberType::i32: return f(std::type_identity<std::int32_t>{});
    case NumberType::u64: return f(std::type_identity<std::uint64_t>{});
    case NumberType::i64: return f(std::type_identity<std::int64_t>{});
    case NumberType::f16: return f(std::type_identity<field::Half>{});
    case NumberType::f32: return f(std::type_identity<float>{});
    case NumberType::f64: break;
  }
  return f(std::type_identity<double>{});
}

[[nodiscard]] std::size_t number_size(NumberType type);
// Returns "u8", "f32", ...
[[nodiscard]] std::string_view number_name(NumberType type);

template <class Bits>
[[nodiscard]] Bits swapped_bytes(Bits bits) {
  if constexpr (sizeof(Bits) == 2) return __builtin_bswap16(bits);
  if constexpr (sizeof(Bits) == 4) return __builtin_bswap32(bits);
  if constexpr (sizeof(Bits) == 8) return __builtin_bswap64(bits);
  return bits;
}

// Calls take(i, value as double) for `count` numbers, `stride` bytes apart from the start of `bytes`.
template <class F>
void for_each_number(NumberType type, std::endian endian, const std::byte* bytes, std::size_t stride, std::size_t count,
                     F&& take) {
  visit_number_type(type, [&]<class T>(std::type_identity<T>) {
    using Bits =
        std::conditional_t<sizeof(T) == 1, std::uint8_t,
                           std::conditional_t<sizeof(T) == 2, std::uint16_t,
                                              std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
    const auto run = [&](auto order) {
      for (std::size_t i = 0; i < count; ++i) {
        Bits bits = 0;
        __builtin_memcpy(&bits, bytes + i * stride, sizeof bits);
        bits = order(bits);
        if constexpr (std::is_same_v<T, field::Half>) {
          field::Half number;
          number.setBits(bits);
          take(i, static_cast<double>(static_cast<float>(number)));
        } else {
          take(i, static_cast<double>(std::bit_cast<T>(bits)));
        }
      }
    };
    if (endian == std::endian::native) {
      run([](Bits bits) { return bits; });
    } else {
      run([](Bits bits) { return swapped_bytes(bits); });
    }
  });
}

}  // namespace isoextract::particle_io

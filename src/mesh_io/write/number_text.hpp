// Writes numbers as the shortest text that reads back as the same number. The text equals that of std::to_chars, but is
// faster to make for the most common numbers of meshes: indices, and coordinates on the planes of a grid.
#pragma once

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace isoextract::mesh_io {

// The bytes that put_number() may overwrite for type T, even if the text is shorter. The longest texts are
// "-1.17549435e-38", "-2.2250738585072014e-308" and "18446744073709551615".
template <class T>
inline constexpr std::size_t kMaxNumberText = std::is_same_v<T, float>    ? 15
                                              : std::is_same_v<T, double> ? 24
                                                                          : 20;

namespace detail {

// Returns the eight decimal digits of a number below 10^8, each as a byte from 0 to 9, the first digit in the lowest
// byte.
// Paul Khuong, "How to print integers really fast" (2017).
constexpr std::uint64_t eight_digits(std::uint32_t number) {
  const std::uint64_t fours = number / 10000 | std::uint64_t{number % 10000} << 32;
  const std::uint64_t tops = fours * 10486 >> 20 & 0x7F0000007F;
  const std::uint64_t twos = tops + ((fours - 100 * tops) << 16);
  const std::uint64_t tens = twos * 103 >> 10 & 0x000F000F000F000F;
  return tens + ((twos - 10 * tens) << 8);
}

}  // namespace detail

template <std::unsigned_integral T>
char* put_number(char* out, T number) {
  constexpr T kEnd = 100'000'000;
  if (number >= kEnd) return std::to_chars(out, out + kMaxNumberText<T>, number).ptr;
  const std::uint64_t digits = detail::eight_digits(static_cast<std::uint32_t>(number));
  const int leading_zeros = digits == 0 ? 7 : __builtin_ctzll(digits) / 8;
  const std::uint64_t text = (digits + 0x3030303030303030) >> 8 * leading_zeros;  // + "00000000"
  std::memcpy(out, &text, sizeof(text));
  return out + 8 - leading_zeros;
}

template <std::floating_point T>
char* put_number(char* out, T number) {
  // Larger whole numbers can be shorter with an exponent: 1e+05.
  constexpr T kWholeBelow = 100'000;
  const T size = std::abs(number);
  if (size < kWholeBelow && size == static_cast<T>(static_cast<std::uint32_t>(size))) {
    *out = '-';
    return put_number(out + (std::signbit(number) ? 1 : 0), static_cast<std::uint32_t>(size));
  }
  return std::to_chars(out, out + kMaxNumberText<T>, number).ptr;
}

}  // namespace isoextract::mesh_io

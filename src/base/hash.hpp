// Mixing of integers: for hash tables, and for numbers that look random and are the same everywhere.
#pragma once

#include <cstdint>

namespace isoextract {

namespace detail {
inline constexpr std::uint64_t kGoldenRatio = 0x9E3779B97F4A7C15U;  // of 2^64, and odd
}

// The n-th number, from 0, of the generator splitmix64 started with 0 (Steele, Lea, Flood: Fast splittable pseudorandom
// number generators. OOPSLA 2014). What is made of them stays the same for ever: demo fields are.
[[nodiscard]] constexpr std::uint64_t splitmix64(std::uint64_t n) {
  std::uint64_t h = (n + 1) * detail::kGoldenRatio;
  h = (h ^ (h >> 30U)) * 0xBF58476D1CE4E5B9U;
  h = (h ^ (h >> 27U)) * 0x94D049BB133111EBU;
  return h ^ (h >> 31U);
}

// 44 bits for a table's place, of three integers; negative ones as they convert. Multiplicative hashing with odd
// constants: the high bits are the well-mixed ones. No output may depend on it.
[[nodiscard]] constexpr std::uint64_t hash_of_three(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  const std::uint64_t mixed = (x * detail::kGoldenRatio + y) * 0xC2B2AE3D27D4EB4FU + z;
  return mixed * detail::kGoldenRatio >> 20U;
}

}  // namespace isoextract

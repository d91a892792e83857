// Integer mixing for hash tables, and for pseudorandom numbers that are the same on every machine.
#pragma once

#include <cstdint>

namespace isoextract {

namespace detail {
inline constexpr std::uint64_t kGoldenRatio = 0x9E3779B97F4A7C15U;  // odd, next to 2^64 / golden ratio
}

// Returns the n-th number (from 0) of the generator splitmix64 with seed 0 (Steele, Lea, Flood: Fast splittable
// pseudorandom number generators. OOPSLA 2014). The numbers must never change: demo fields and simulations use them.
[[nodiscard]] constexpr std::uint64_t splitmix64(std::uint64_t n) {
  std::uint64_t h = (n + 1) * detail::kGoldenRatio;
  h = (h ^ (h >> 30U)) * 0xBF58476D1CE4E5B9U;
  h = (h ^ (h >> 27U)) * 0x94D049BB133111EBU;
  return h ^ (h >> 31U);
}

// Returns a 44-bit hash of three integers for a table index; cast negative integers. This is multiplicative hashing
// with odd constants: the high bits are mixed best. No output may depend on the hash.
[[nodiscard]] constexpr std::uint64_t hash_coordinates(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  const std::uint64_t mixed = (x * detail::kGoldenRatio + y) * 0xC2B2AE3D27D4EB4FU + z;
  return mixed * detail::kGoldenRatio >> 20U;
}

}  // namespace isoextract

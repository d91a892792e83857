// Overflow-checked arithmetic for sizes that come from files.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>

namespace isoextract {

// Returns the product of all factors. Returns nothing if an intermediate product, from left to right, exceeds 64 bits,
// even if a later factor is 0.
template <std::unsigned_integral... Ts>
[[nodiscard]] constexpr std::optional<std::uint64_t> checked_product(Ts... factors) {
  std::uint64_t product = 1;
  bool overflow = false;
  ((overflow = __builtin_mul_overflow(product, std::uint64_t{factors}, &product) || overflow), ...);
  if (overflow) return std::nullopt;
  return product;
}

// Returns the sum of all terms, or nothing if it exceeds 64 bits.
template <std::unsigned_integral... Ts>
[[nodiscard]] constexpr std::optional<std::uint64_t> checked_sum(Ts... terms) {
  std::uint64_t sum = 0;
  bool overflow = false;
  ((overflow = __builtin_add_overflow(sum, std::uint64_t{terms}, &sum) || overflow), ...);
  if (overflow) return std::nullopt;
  return sum;
}

}  // namespace isoextract

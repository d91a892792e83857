// Helpers for rows of inside bits, in words of 64 bits.
#pragma once

#include <bit>
#include <cstdint>

namespace isoextract::extract {

// Calls f(position) for each set bit, lowest first.
template <class F>
void for_each_bit(std::uint64_t word, F&& f) {
  for (; word != 0; word &= word - 1) f(std::countr_zero(word));
}

// Returns the number of set bits (Warren: Hacker's Delight, 5-1). Unless GCC may assume a popcount instruction,
// std::popcount() is a library call, which slows the inner loops of label maps.
[[nodiscard]] constexpr int count_bits(std::uint64_t word) {
  word -= word >> 1 & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + (word >> 2 & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0F0F0F0F0F0F0F0FU;
  return static_cast<int>(word * 0x0101010101010101U >> 56);
}

// Returns a mask of the bits of word w that stand for positions below `limit` in the row.
[[nodiscard]] inline std::uint64_t bits_below(int w, int limit) {
  const int rest = limit - 64 * w;
  if (rest >= 64) return ~std::uint64_t{0};
  return rest <= 0 ? 0 : (std::uint64_t{1} << rest) - 1;
}

// Returns word w shifted by one: bit b is that of the sample after sample b. Reads word w + 1, too.
[[nodiscard]] inline std::uint64_t next_bits(const std::uint64_t* row, int w) { return row[w] >> 1 | row[w + 1] << 63; }

}  // namespace isoextract::extract

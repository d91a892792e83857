// Words of 64 inside bits along a row of samples.
#pragma once

#include <bit>
#include <cstdint>

namespace isoextract::extract {

// Calls f(position) for each set bit, rising.
template <class F>
void for_each_bit(std::uint64_t word, F&& f) {
  for (; word != 0; word &= word - 1) f(std::countr_zero(word));
}

// Bits of word w of a row whose position is below `limit`.
[[nodiscard]] inline std::uint64_t bits_below(int w, int limit) {
  const int rest = limit - 64 * w;
  if (rest >= 64) return ~std::uint64_t{0};
  return rest <= 0 ? 0 : (std::uint64_t{1} << rest) - 1;
}

// Word w, moved by one: bit b is that of the sample after b.
[[nodiscard]] inline std::uint64_t next_bits(const std::uint64_t* row, int w) { return row[w] >> 1 | row[w + 1] << 63; }

}  // namespace isoextract::extract

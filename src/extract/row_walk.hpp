// The bits of one row of cells, word by word: which edges are crossed and which cells the surface passes.
#pragma once

#include <bit>
#include <cstdint>

#include "extract/cell_streams.hpp"
#include "extract/dense_masks.hpp"

namespace isoextract {

// Calls f(position) for each set bit, rising.
template <class F>
void for_each_bit(std::uint64_t word, F&& f) {
  for (; word != 0; word &= word - 1) f(std::countr_zero(word));
}

// The four sample rows of a row of cells, from sample row (j, k) on. Where j or k is the last, there are no cells, and
// edges towards the missing rows do not exist.
class RowBits {
 public:
  RowBits(const DenseMasks& masks, int j, int k) : dims_(masks.dims()) {
    for (int dz = 0; dz < 2; ++dz) {
      for (int dy = 0; dy < 2; ++dy) {
        rows_[dy][dz] = j + dy < dims_.y && k + dz < dims_.z ? masks.row(j + dy, k + dz) : nullptr;
      }
    }
  }

  [[nodiscard]] bool has_cells() const { return rows_[1][1] != nullptr; }

  // The crossed edges of `stream` owned by samples 64 w .. 64 w + 63.
  template <class Stream>
  [[nodiscard]] std::uint64_t crossed(const Stream& stream, int w) const {
    const std::uint64_t* lower = rows_[stream.row_y][stream.row_z];
    const int upper_y = stream.row_y + (stream.direction >> 1 & 1);
    const int upper_z = stream.row_z + (stream.direction >> 2 & 1);
    const std::uint64_t* upper = rows_[upper_y][upper_z];
    if (lower == nullptr || upper == nullptr) return 0;
    const bool along_x = (stream.direction & 1) != 0;
    return (lower[w] ^ (along_x ? next(upper, w) : upper[w])) & valid(w, along_x ? dims_.x - 1 : dims_.x);
  }

  // The inside bits of the eight cell corners, for the cells of word w. Only where has_cells().
  using Corners = std::array<std::uint64_t, 8>;
  [[nodiscard]] Corners corners(int w) const {
    Corners words;
    for (int c = 0; c < 8; c += 2) {
      const std::uint64_t* row = rows_[c >> 1 & 1][c >> 2 & 1];
      words[c] = row[w];
      words[c + 1] = next(row, w);
    }
    return words;
  }

  // The cells of word w with corners on both sides.
  [[nodiscard]] std::uint64_t active_cells(const Corners& corners, int w) const {
    return mixed(corners) & valid(w, dims_.x - 1);
  }

  // Positions at which not all eight words agree.
  static std::uint64_t mixed(const Corners& corners) {
    std::uint64_t any = 0;
    std::uint64_t all = ~std::uint64_t{0};
    for (const std::uint64_t word : corners) {
      any |= word;
      all &= word;
    }
    return any & ~all;
  }

  static unsigned cell_case(const Corners& corners, int cell) {
    unsigned bits = 0;
    for (int c = 0; c < 8; ++c) bits |= static_cast<unsigned>(corners[c] >> cell & 1) << c;
    return bits;
  }

  // Bits of word w whose position is below `limit`.
  static std::uint64_t valid(int w, int limit) {
    const int rest = limit - 64 * w;
    if (rest >= 64) return ~std::uint64_t{0};
    return rest <= 0 ? 0 : (std::uint64_t{1} << rest) - 1;
  }

 private:
  static std::uint64_t next(const std::uint64_t* row, int w) { return row[w] >> 1 | row[w + 1] << 63; }

  glm::ivec3 dims_;
  const std::uint64_t* rows_[2][2];
};

}  // namespace isoextract

// Processes rows of cells: finds their crossed edges, counts their triangles, writes them. Works on inside bits in
// words of 64 samples, and reads samples only if a case alone does not decide (VariantChooser). Vectorized.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "base/buffer.hpp"
#include "extract/detail/cell_drawings.hpp"

namespace isoextract::extract {

inline constexpr int kMaxDirections = 7;
inline constexpr int kMaxStreams = 14;

// Returns drawings whose triangles hold a slot for each edge. The slot is the number of the edge's stream
// (CellStreams), plus kSlotsPerSide if the edge is at the position after the cell's.
inline constexpr int kSlotsPerSide = 16;
[[nodiscard]] CellDrawings row_drawings(const CaseTable& table, bool mirrored, bool decide_all);

// The cells between four rows of samples. Bits are as in DenseMasks: zero after the last sample, with one extra word.
struct CellRow {
  glm::ivec3 origin;  // position of the row, for the VariantChooser
  // The bits of row (j, k), then of the next row along y, along z, and along both. Null if a row does not exist; then
  // there are no cells and no edges toward it.
  std::array<const std::uint64_t*, 4> bits;
  int samples;                         // samples in a row
  const std::uint8_t* crossed_bricks;  // one byte a word: 0 if all samples of the brick are on one side

  [[nodiscard]] bool has_cells() const { return bits[3] != nullptr; }
};

struct RowCounts {
  std::array<std::uint32_t, kMaxDirections> vertices{};  // crossed edges that the row's samples own, by direction
  CellCounts cells;
};

[[nodiscard]] RowCounts count_cells(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider);

// Writes the triangles of a row that has cells. `out` has room for exactly the counted number. `first` holds the number
// of each stream's first vertex (CellStreams). Returns false if the number of triangles differs from the count, because
// `decider` now answers otherwise. Never writes past the end of `out`.
[[nodiscard]] bool write_cells(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider,
                               std::span<const std::uint32_t> first, std::span<glm::uvec3> out);

// Positions in a row of the crossed edges of each direction d, rising: from begin(d) to end(d). Reused from row to row.
class EdgeList {
 public:
  EdgeList(int directions, int samples)
      : positions_(static_cast<std::size_t>(directions) * static_cast<std::size_t>(samples) + kSpare) {}

  [[nodiscard]] const std::int32_t* begin(int direction) const { return positions_.data() + first_[direction]; }
  [[nodiscard]] const std::int32_t* end(int direction) const { return positions_.data() + first_[direction + 1]; }

  static constexpr std::size_t kSpare = 4;  // list_edges() may write this many entries after the last position
  [[nodiscard]] std::int32_t* positions() { return positions_.data(); }
  [[nodiscard]] std::array<std::int32_t, kMaxDirections + 1>& first() { return first_; }

 private:
  Buffer<std::int32_t> positions_;
  std::array<std::int32_t, kMaxDirections + 1> first_{};
};

// Fills `edges` with the crossed edges that the samples of the row own.
void list_edges(const CellDrawings& drawings, const CellRow& row, EdgeList& edges);

// Sets one byte for each word in `crossed`: 1 if samples of the word in `rows` are on both sides of the iso value, else
// 0. Each row has `samples` samples. The samples of a word include the first of the next word.
void mark_crossed_words(std::span<const std::uint64_t* const> rows, int samples, std::uint8_t* crossed);

}  // namespace isoextract::extract

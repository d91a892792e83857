// Rows of cells: which edges they cross, how many triangles they draw, and the triangles. Works on inside bits, a word
// of 64 samples at a time, and looks at samples only where a case alone does not decide (CellDecider). Vectorised.
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

// What cells draw, with corners of triangles as slots: stream of CellStreams, plus kSlotsPerSide for the position after
// the cell's.
inline constexpr int kSlotsPerSide = 16;
[[nodiscard]] CellDrawings row_drawings(const CaseTable& table, bool mirrored, bool decide_all);

// The cells between four rows of samples. Bits are those of DenseMasks: zero after the last sample, and one more word.
struct CellRow {
  glm::ivec3 origin;  // of the row, for the decider
  // Row (j, k), then the next along y, along z, along both. Null where there is none; then there are no cells, and no
  // edges towards it.
  std::array<const std::uint64_t*, 4> bits;
  int samples;                         // in a row
  const std::uint8_t* crossed_bricks;  // a byte a word: 0 where all samples around are on one side

  [[nodiscard]] bool has_cells() const { return bits[3] != nullptr; }
};

struct RowCounts {
  std::array<std::uint32_t, kMaxDirections> vertices{};  // of the edges the row's samples own, by direction
  CellCounts cells;
};

[[nodiscard]] RowCounts count_cells(const CellDrawings& drawings, const CellRow& row, const CellDecider& decider);

// Writes the triangles of a row that has cells to `out`, which has room for just as many as were counted. `first` is
// the number of each stream's first vertex (CellStreams). False if it is another number of triangles, because the
// decider changed its mind; nothing is written past the end then.
[[nodiscard]] bool write_cells(const CellDrawings& drawings, const CellRow& row, const CellDecider& decider,
                               std::span<const std::uint32_t> first, std::span<glm::uvec3> out);

// Where along the row the crossed edges of each direction begin: positions from edges.begin(d) to edges.begin(d + 1),
// rising. Reused from row to row.
class EdgeList {
 public:
  EdgeList(int directions, int samples)
      : positions_(static_cast<std::size_t>(directions) * static_cast<std::size_t>(samples) + kSpare) {}

  [[nodiscard]] const std::int32_t* begin(int direction) const { return positions_.data() + first_[direction]; }
  [[nodiscard]] const std::int32_t* end(int direction) const { return positions_.data() + first_[direction + 1]; }

  static constexpr std::size_t kSpare = 4;  // that may be written behind the last position
  [[nodiscard]] std::int32_t* positions() { return positions_.data(); }
  [[nodiscard]] std::array<std::int32_t, kMaxDirections + 1>& first() { return first_; }

 private:
  Buffer<std::int32_t> positions_;
  std::array<std::int32_t, kMaxDirections + 1> first_{};
};

void list_edges(const CellDrawings& drawings, const CellRow& row, EdgeList& edges);

// Which words have samples on both sides in any of `rows`, all of one length: `crossed` gets a byte a word. A word's
// samples include the first of the next one.
void mark_crossed_words(std::span<const std::uint64_t* const> rows, int samples, std::uint8_t* crossed);

}  // namespace isoextract::extract

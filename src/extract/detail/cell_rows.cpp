#include "extract/detail/cell_rows.hpp"

#include <bit>

#include "base/simd_targets.hpp"
#include "extract/detail/cell_streams.hpp"
#include "extract/row_bits.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "extract/detail/cell_rows.cpp"  // included once for each instruction set
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace isoextract::extract {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// One word of the four sample rows, unmoved and moved by one sample along x.
struct Corners {
  std::uint64_t own[4];
  std::uint64_t next[4];
};

HWY_INLINE Corners load_corners(const CellRow& row, int w) {
  Corners corners;
  for (int r = 0; r < 4; ++r) {
    const std::uint64_t* bits = row.bits[r];
    corners.own[r] = bits != nullptr ? bits[w] : 0;
    corners.next[r] = bits != nullptr ? next_bits(bits, w) : 0;
  }
  return corners;
}

// Returns the crossed edges of one stream in this word.
HWY_INLINE std::uint64_t crossed_edges(const Corners& corners, int direction, int row, std::uint64_t before_last) {
  const int upper = row + (direction >> 1);
  const bool along_x = (direction & 1) != 0;
  return along_x ? (corners.own[row] ^ corners.next[upper]) & before_last : corners.own[row] ^ corners.own[upper];
}

HWY_INLINE std::uint64_t active_cells(const Corners& c, std::uint64_t before_last) {
  const std::uint64_t any = c.own[0] | c.own[1] | c.own[2] | c.own[3] | c.next[0] | c.next[1] | c.next[2] | c.next[3];
  const std::uint64_t all = c.own[0] & c.own[1] & c.own[2] & c.own[3] & c.next[0] & c.next[1] & c.next[2] & c.next[3];
  return any & ~all & before_last;
}

HWY_INLINE unsigned cell_case(const Corners& corners, int cell) {
  unsigned bits = 0;
  if (HWY_LIKELY(cell < 63)) {
    for (int r = 0; r < 4; ++r) bits |= static_cast<unsigned>(corners.own[r] >> cell & 3) << (2 * r);
    return bits;
  }
  for (int r = 0; r < 4; ++r) {
    bits |= static_cast<unsigned>((corners.own[r] >> cell & 1) | (corners.next[r] >> cell & 1) << 1) << (2 * r);
  }
  return bits;
}

template <int kDirections>
RowCounts count_row(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider) {
  constexpr auto& kStreams = kCellStreams<kDirections>.streams;
  RowCounts counts;
  const bool has_cells = row.has_cells();
  const int words = (row.samples + 63) / 64;
  for (int w = 0; w < words; ++w) {
    if (row.crossed_bricks[w] == 0) continue;
    const Corners corners = load_corners(row, w);
    const std::uint64_t before_last = bits_below(w, row.samples - 1);
    for (int s = 0, d = 0; d < kDirections; ++s) {
      if (kStreams[s].row != 0) continue;
      const int upper = kStreams[s].direction >> 1;
      if (row.bits[upper] != nullptr) {
        counts.vertices[d] +=
            static_cast<std::uint32_t>(std::popcount(crossed_edges(corners, kStreams[s].direction, 0, before_last)));
      }
      ++d;
    }
    if (!has_cells) continue;
    for (std::uint64_t rest = active_cells(corners, before_last); rest != 0; rest &= rest - 1) {
      const int cell = std::countr_zero(rest);
      counts.cells.add(drawings.of(cell_case(corners, cell), decider, row.origin, {64 * w + cell, 0, 0}));
    }
  }
  return counts;
}

template <int kDirections>
bool write_row(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider,
               std::span<const std::uint32_t> first, std::span<glm::uvec3> room) {
  glm::uvec3* out = room.data();
  glm::uvec3* const end = out + room.size();
  constexpr auto& kStreams = kCellStreams<kDirections>.streams;
  constexpr int kCount = CellStreams<kDirections>::kStreams;
  constexpr int kSide = kSlotsPerSide;
  const hn::CappedTag<std::uint64_t, 8> d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto one = hn::Set(d, 1);
  // By stream: number of the next vertex, and crossed edges of the word. By slot: vertex numbers around a cell.
  alignas(64) std::uint64_t next[kSide];
  alignas(64) std::uint64_t crossed[kSide];
  alignas(64) std::uint64_t numbers[2 * kSide];
  for (int s = 0; s < kCount; ++s) next[s] = first[static_cast<std::size_t>(s)];
  for (int s = kCount; s < kSide && kCount % 8 != 0; ++s) next[s] = crossed[s] = 0;

  const int words = (row.samples + 63) / 64;
  for (int w = 0; w < words; ++w) {
    if (row.crossed_bricks[w] == 0) continue;
    const Corners corners = load_corners(row, w);
    const std::uint64_t before_last = bits_below(w, row.samples - 1);
    std::uint64_t rest = active_cells(corners, before_last);
    if (rest == 0) continue;
#pragma GCC unroll 16
    for (int s = 0; s < kCount; ++s) {
      crossed[s] = crossed_edges(corners, kStreams[s].direction, kStreams[s].row, before_last);
    }
    for (; rest != 0; rest &= rest - 1) {
      const int cell = std::countr_zero(rest);
#pragma GCC unroll 8
      for (int s = 0; s < kCount; s += lanes) {
        const auto at = hn::Load(d, next + s);
        const auto after = hn::Add(at, hn::And(hn::ShiftRightSame(hn::Load(d, crossed + s), cell), one));
        hn::Store(at, d, numbers + s);
        hn::Store(after, d, numbers + kSide + s);
        hn::Store(after, d, next + s);
      }
      const auto drawing = drawings.of(cell_case(corners, cell), decider, row.origin, {64 * w + cell, 0, 0});
      if (HWY_UNLIKELY(end - out < drawing.count)) return false;
      out = drawings.write(drawing, numbers, out);
    }
  }
  return out == end;
}

RowCounts count_any(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider) {
  return (drawings.directions() == 3 ? count_row<3> : count_row<7>)(drawings, row, decider);
}

bool write_any(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider,
               std::span<const std::uint32_t> first, std::span<glm::uvec3> out) {
  return (drawings.directions() == 3 ? write_row<3> : write_row<7>)(drawings, row, decider, first, out);
}

// Writes the positions of set bits to `out`, four at a time, which reduces mispredicted branches.
HWY_INLINE std::int32_t* list_bits(std::uint64_t bits, std::int32_t base, std::int32_t* out) {
  const int count = std::popcount(bits);
  for (int i = 0; i < count; i += static_cast<int>(EdgeList::kSpare)) {
    for (int u = 0; u < static_cast<int>(EdgeList::kSpare); ++u) {
      out[i + u] = base + std::countr_zero(bits);
      bits &= bits - 1;
    }
  }
  return out + count;
}

void list_any(const CellDrawings& drawings, const CellRow& row, EdgeList& edges) {
  const int words = (row.samples + 63) / 64;
  std::int32_t* out = edges.positions();
  const int directions = drawings.directions();
  for (int d = 0, direction = 1; d < directions; ++d, direction += directions == 3 ? direction : 1) {
    const std::uint64_t* upper = row.bits[direction >> 1];
    const bool along_x = (direction & 1) != 0;
    for (int w = 0; upper != nullptr && w < words; ++w) {
      if (row.crossed_bricks[w] == 0) continue;
      const std::uint64_t ends = along_x ? next_bits(upper, w) : upper[w];
      const std::uint64_t valid = bits_below(w, along_x ? row.samples - 1 : row.samples);
      out = list_bits((row.bits[0][w] ^ ends) & valid, 64 * w, out);
    }
    edges.first()[static_cast<std::size_t>(d) + 1] = static_cast<std::int32_t>(out - edges.positions());
  }
}

void mark_any(std::span<const std::uint64_t* const> rows, int samples, std::uint8_t* crossed) {
  const int words = (samples + 63) / 64;
  for (int w = 0; w < words; ++w) {
    std::uint64_t any = 0;
    std::uint64_t all = ~std::uint64_t{0};
    std::uint64_t any_next = 0;
    std::uint64_t all_next = ~std::uint64_t{0};
    for (const std::uint64_t* bits : rows) {
      any |= bits[w];
      all &= bits[w];
      any_next |= bits[w + 1];
      all_next &= bits[w + 1];
    }
    // The word's own samples, and the first of the next word.
    const std::uint64_t own = bits_below(w, samples);
    const std::uint64_t shared = 64 * (w + 1) < samples ? 1 : 0;
    const bool inside = (any & own) != 0 || (any_next & shared) != 0;
    const bool outside = (~all & own) != 0 || (~all_next & shared) != 0;
    crossed[w] = inside && outside ? 1 : 0;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace isoextract::extract
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isoextract::extract {

HWY_EXPORT(count_any);
HWY_EXPORT(write_any);
HWY_EXPORT(list_any);
HWY_EXPORT(mark_any);

RowCounts count_cells(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider) {
  return HWY_DYNAMIC_DISPATCH(count_any)(drawings, row, decider);
}

bool write_cells(const CellDrawings& drawings, const CellRow& row, const VariantChooser& decider,
                 std::span<const std::uint32_t> first, std::span<glm::uvec3> out) {
  return HWY_DYNAMIC_DISPATCH(write_any)(drawings, row, decider, first, out);
}

void list_edges(const CellDrawings& drawings, const CellRow& row, EdgeList& edges) {
  HWY_DYNAMIC_DISPATCH(list_any)(drawings, row, edges);
}

void mark_crossed_words(std::span<const std::uint64_t* const> rows, int samples, std::uint8_t* crossed) {
  HWY_DYNAMIC_DISPATCH(mark_any)(rows, samples, crossed);
}

CellDrawings row_drawings(const CaseTable& table, bool mirrored, bool decide_all) {
  std::vector<std::uint8_t> slots;
  const auto add = [&](const auto& streams) {
    for (const auto& source : streams.edges) {
      slots.push_back(static_cast<std::uint8_t>(source.stream + (source.next ? kSlotsPerSide : 0)));
    }
  };
  table.directions.size() == 3 ? add(kCellStreams<3>) : add(kCellStreams<7>);
  return {table, mirrored, decide_all, slots};
}

}  // namespace isoextract::extract
#endif

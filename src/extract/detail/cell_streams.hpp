// Vertex numbers while the dense extractor walks along a row of cells.
//
// A stream is the sequence of crossed edges of one direction that the samples of one row own. Their vertices have
// consecutive numbers. A cell's edges belong to the streams of its four rows, at the cell's own position or the next
// one. All edges of a stream before a cell belong to earlier cells of the row. So walking over the cells in order and
// adding the bit of each stream keeps all numbers right with one addition a stream.
#pragma once

#include <array>
#include <cstdint>

#include "extract/cell_tables.hpp"

namespace isoextract::extract {

// Returns the index of axis bits in CaseTable::directions.
template <int kDirections>
[[nodiscard]] constexpr int direction_index(int direction) {
  return kDirections == 3 ? direction / 2 : direction - 1;
}

// The streams and edges of a cell, in the order of CaseTable::edges: by direction, then by corner.
template <int kDirections>
struct CellStreams {
  static_assert(kDirections == 3 || kDirections == 7);
  static constexpr int kEdges = kDirections == 3 ? 12 : 19;
  static constexpr int kStreams = kDirections == 3 ? 8 : 14;

  struct Stream {
    int direction = 0;  // axis bits
    int row = 0;        // the row whose samples own the edges: 0 the cell's first, +1 the next along y, +2 along z
  };
  struct EdgeSource {
    int stream = 0;
    bool next = false;  // the edge is at the position after the cell's
  };

  std::array<Stream, kStreams> streams{};
  std::array<EdgeSource, kEdges> edges{};

  constexpr CellStreams() {
    int stream_count = 0;
    int edge = 0;
    for (int direction = 1; direction < 8; direction += kDirections == 3 ? direction : 1) {
      for (int corner = 0; corner < 8; ++corner) {
        if ((corner & direction) != 0) continue;
        const int row = corner >> 1;
        int stream = 0;
        while (stream < stream_count && !(streams[stream].direction == direction && streams[stream].row == row)) {
          ++stream;
        }
        if (stream == stream_count) streams[stream_count++] = {direction, row};
        edges[edge++] = {stream, (corner & 1) != 0};
      }
    }
  }
};

// The streams of the cell's first row (row 0) come in the order of CaseTable::directions.
template <int kDirections>
inline constexpr CellStreams<kDirections> kCellStreams{};

}  // namespace isoextract::extract

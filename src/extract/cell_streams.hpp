// How the extractors number vertices while they walk along a row of cells.
//
// A stream is the sequence of crossed edges of one direction, owned by the samples of one row; their vertices have
// consecutive numbers. A cell's edges belong to the streams of its four rows, at the cell's own position or the next.
// Every edge of a stream that lies before a cell belongs to an earlier cell of the same row, so walking over the cells
// in order and adding each stream's bit keeps all numbers right with one addition a stream.
#pragma once

#include <array>
#include <cstdint>

#include "extract/cell_tables.hpp"

namespace isoextract {

// The place of axis bits in CaseTable::directions.
template <int kDirections>
[[nodiscard]] constexpr int direction_index(int direction) {
  return kDirections == 3 ? direction / 2 : direction - 1;
}

template <int kDirections>
struct CellStreams {
  static_assert(kDirections == 3 || kDirections == 7);
  static constexpr int kEdges = kDirections == 3 ? 12 : 19;
  static constexpr int kStreams = kDirections == 3 ? 8 : 14;

  struct Stream {
    int direction_index;  // into CaseTable::directions
    int direction;        // axis bits
    int row_y, row_z;     // which of the cell's rows owns the edges
  };
  struct EdgeSource {
    int stream;
    bool next;  // at the position after the cell's
  };

  std::array<Stream, kStreams> streams{};
  std::array<EdgeSource, kEdges> edges{};  // for each edge of the table

  explicit CellStreams(const CaseTable& table) {
    int count = 0;
    for (std::size_t e = 0; e < table.edges.size(); ++e) {
      const CellEdge edge = table.edges[e];
      const int row_y = edge.corner >> 1 & 1;
      const int row_z = edge.corner >> 2 & 1;
      int stream = 0;
      while (stream < count && !(streams[stream].direction == edge.direction && streams[stream].row_y == row_y &&
                                 streams[stream].row_z == row_z)) {
        ++stream;
      }
      if (stream == count) {
        streams[count++] = {direction_index<kDirections>(edge.direction), edge.direction, row_y, row_z};
      }
      edges[e] = {stream, (edge.corner & 1) != 0};
    }
  }
};

}  // namespace isoextract

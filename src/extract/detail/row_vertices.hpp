// Makes the vertices of a row of dense samples.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "extract/cell_tables.hpp"
#include "extract/dense_masks.hpp"
#include "extract/detail/cell_rows.hpp"
#include "extract/detail/sample_gradient.hpp"
#include "extract/detail/vertex_batch.hpp"

namespace isoextract::extract {

// Adds crossed edges to a batch that has room for them: those toward `direction` from the samples at `positions` of the
// row that begins with sample `low` of the view.
template <class T>
void add_edges(const DenseView<T>& whole, const glm::ivec3& low, std::span<const std::int32_t> positions, int direction,
               bool gradients, VertexBatch& batch) {
  const glm::ivec3 step = direction_step(direction);
  const std::array<const T*, 2> ends{whole.row(low.y, low.z) + low.x,
                                     whole.row(low.y + step.y, low.z + step.z) + low.x + step.x};
  const int first = batch.count;
  int i = first;
  for (const std::int32_t x : positions) {
    batch.value[0][i] = static_cast<double>(ends[0][x]);
    batch.value[1][i] = static_cast<double>(ends[1][x]);
    batch.low[0][i] = low.x + x;
    batch.low[1][i] = low.y;
    batch.low[2][i] = low.z;
    batch.direction[i] = direction;
    ++i;
  }
  batch.count = i;
  if (!gradients) return;
  for (int end = 0; end < 2; ++end) {
    const glm::ivec3 row = low + end * step;
    for (i = first; i < batch.count; ++i) {
      const glm::dvec3 g =
          sample_gradient(whole, {row.x + positions[static_cast<std::size_t>(i - first)], row.y, row.z});
      for (int axis = 0; axis < 3; ++axis) batch.gradient[end][axis][i] = g[axis];
    }
  }
}

// Writes the vertices on the crossed edges that the samples of `row` own, in the order of their numbers. `low` is the
// row's first sample in the view. `edges` is memory for them.
template <class T>
void write_row_vertices(const CaseTable& table, const CellDrawings& drawings, const CellRow& row,
                        const DenseView<T>& whole, const glm::ivec3& low, EdgeList& edges, VertexWriter& writer) {
  VertexBatch& batch = writer.batch();
  list_edges(drawings, row, edges);
  for (int d = 0; d < static_cast<int>(table.directions.size()); ++d) {
    const int direction = table.directions[static_cast<std::size_t>(d)];
    for (const std::int32_t* x = edges.begin(d); x != edges.end(d);) {
      const auto room = static_cast<std::ptrdiff_t>(VertexBatch::kCapacity - batch.count);
      const std::int32_t* end = x + std::min(room, edges.end(d) - x);
      add_edges(whole, low, std::span(x, end), direction, writer.wants_gradients(), batch);
      x = end;
      writer.flush_if_full();
    }
  }
}

}  // namespace isoextract::extract

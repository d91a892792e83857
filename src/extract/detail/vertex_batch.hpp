// Vertices on crossed edges, placed many at a time. Vectorised; edge_crossing() and OutputFrame (edge_geometry.hpp) say
// the same in plain words, and place what is not finite.
#pragma once

#include <cstddef>
#include <cstdint>

#include "extract/edge_geometry.hpp"
#include "extract/inside_test.hpp"

namespace isoextract::extract {

// Edges whose vertices get consecutive numbers. Filled by whoever walks over the samples, then written to a mesh.
class VertexBatch {
 public:
  static constexpr int kCapacity = 256;

  // Entries 0 .. count - 1 are in use. An edge goes from sample `low` one step along the axes of `direction` (bits).
  int count = 0;
  alignas(64) double value[2][kCapacity];        // stored numbers at both ends
  alignas(64) double gradient[2][3][kCapacity];  // of stored numbers, along x, y, z; only where the mesh has normals
  alignas(64) std::int32_t low[3][kCapacity];
  alignas(64) std::int32_t direction[kCapacity];

  [[nodiscard]] bool full() const { return count == kCapacity; }
};

// What all vertices of a mesh have in common. The references must outlive it.
struct VertexRules {
  const OutputFrame& placement;
  InsideRule inside;
  field::ValueScale scale;
};

// Writes positions from `first` on, and normals and edge keys where the mesh has them, and empties the batch.
void write_vertices(VertexBatch& batch, const VertexRules& rules, mesh::Mesh& mesh, std::size_t first);

// Writes vertices to a mesh in the order of their numbers, a batch at a time. What was added last is written by the
// last flush().
class VertexWriter {
 public:
  // `number` is that of the first vertex.
  VertexWriter(const VertexRules& rules, mesh::Mesh& mesh, std::size_t number)
      : rules_(rules), mesh_(mesh), number_(number) {}

  [[nodiscard]] bool wants_gradients() const { return !mesh_.normals.empty(); }

  // There is room in it; after adding to it, flush_full().
  [[nodiscard]] VertexBatch& batch() { return batch_; }
  void flush_full() {
    if (batch_.full()) flush();
  }
  void flush() {
    const auto count = static_cast<std::size_t>(batch_.count);
    write_vertices(batch_, rules_, mesh_, number_);
    number_ += count;
  }
  // The next vertex has another number than the one after the last.
  void go_on_at(std::size_t number) {
    flush();
    number_ = number;
  }

 private:
  VertexRules rules_;
  mesh::Mesh& mesh_;
  std::size_t number_;  // of the batch's first vertex
  VertexBatch batch_;
};

}  // namespace isoextract::extract

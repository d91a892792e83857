// Computes positions and normals of vertices on crossed edges, many at a time. Vectorized; edge_crossing() and
// OutputPlacement (edge_geometry.hpp) are the readable version and handle values that are not finite.
#pragma once

#include <cstddef>
#include <cstdint>

#include "extract/edge_geometry.hpp"
#include "extract/inside_test.hpp"

namespace isoextract::extract {

// A batch of crossed edges whose vertices have consecutive numbers. Code that walks over the samples fills it;
// write_vertices() writes it to a mesh.
class VertexBatch {
 public:
  static constexpr int kCapacity = 256;

  // Entries 0 to count - 1 are used. An edge goes from sample `low` one step along the axes of `direction` (bits).
  int count = 0;
  alignas(64) double value[2][kCapacity];        // stored sample values at both ends
  alignas(64) double gradient[2][3][kCapacity];  // gradients of stored values along x, y, z, at both ends; only if the
                                                 // mesh has normals
  alignas(64) std::int32_t low[3][kCapacity];
  alignas(64) std::int32_t direction[kCapacity];

  [[nodiscard]] bool full() const { return count == kCapacity; }
};

// Data shared by all vertices of a mesh. The references must outlive it.
struct VertexRules {
  const OutputPlacement& placement;
  InsideRule inside;
  field::ValueScale scale;
};

// Writes the batch to the mesh from vertex `first` on: positions, and normals and edge keys if the mesh has them. Then
// empties the batch.
void write_vertices(VertexBatch& batch, const VertexRules& rules, mesh::Mesh& mesh, std::size_t first);

// Writes vertices to a mesh in the order of their numbers, a batch at a time. Call flush() after the last one.
class VertexWriter {
 public:
  // `number` is the number of the first vertex.
  VertexWriter(const VertexRules& rules, mesh::Mesh& mesh, std::size_t number)
      : rules_(rules), mesh_(mesh), number_(number) {}

  [[nodiscard]] bool wants_gradients() const { return !mesh_.normals.empty(); }

  // Returns the batch, which has room for one more entry. Call flush_if_full() after adding one.
  [[nodiscard]] VertexBatch& batch() { return batch_; }
  void flush_if_full() {
    if (batch_.full()) flush();
  }
  void flush() {
    const auto count = static_cast<std::size_t>(batch_.count);
    write_vertices(batch_, rules_, mesh_, number_);
    number_ += count;
  }
  // Continues with vertex `number` instead of the one after the last.
  void continue_at(std::size_t number) {
    flush();
    number_ = number;
  }

 private:
  VertexRules rules_;
  mesh::Mesh& mesh_;
  std::size_t number_;  // number of the batch's first vertex
  VertexBatch batch_;
};

}  // namespace isoextract::extract

// Counts the vertices of a surface in each brick during its extraction, without holding the surface.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "accuracy/detail/search_window.hpp"
#include "base/context.hpp"
#include "mesh/mesh_sink.hpp"

namespace isoextract::accuracy {

class BrickCounter final : public mesh::MeshSink {
 public:
  // Declines surfaces of at most `most_whole` triangles, which the caller then gets as a whole. `index_from_output`
  // maps positions to index space.
  BrickCounter(std::uint64_t most_whole, const CellFinder& cells, const field::Affine& index_from_output,
               const Context& context)
      : most_whole_(most_whole), cells_(cells), index_from_output_(index_from_output), context_(context) {}

  Result<bool> begin(const mesh::MeshShape& shape) override;
  [[nodiscard]] std::vector<mesh::PartPass> passes() const override {
    return {{.positions = true, .normals = false, .triangles = false}};
  }
  Result<void> take(const mesh::MeshPart& part) override;

  [[nodiscard]] std::uint64_t triangles() const { return shape_.triangles; }
  // Returns the bricks in the order of merge_bricks(), with the surface's triangles divided as its vertices are. Call
  // it once, after the last part.
  [[nodiscard]] std::vector<BrickCount> take_bricks();

 private:
  std::uint64_t most_whole_;
  const CellFinder& cells_;
  field::Affine index_from_output_;
  Context context_;
  mesh::MeshShape shape_;
  std::mutex mutex_;  // of the members below
  Reservation memory_;
  std::size_t most_ = 0;  // bricks in the list before it is merged again
  std::vector<BrickCount> bricks_;
};

}  // namespace isoextract::accuracy

// Surface nets: smooth places for the corners of voxels where the border of a label passes, one for all labels.
//
// The net has a point in each cell of the grid whose eight samples have more than one label: the corner of the voxels,
// in the middle of the cell. Points are joined where the cells share a face that has more than one label. Each point
// moves towards the mean of those it is joined with, and a little back, so that wide parts keep their volume (Taubin: A
// signal processing approach to fair surface design. 1995); it stays within its cell (Gibson: Constrained Elastic
// Surface Nets. 1998). Where three labels or more meet in a face of the cell, a curve in which they meet passes; points
// on it are moved by their neighbours on it alone, so that it stays a smooth curve, and no border that ends in it pulls
// at it (Frisken: SurfaceNets for Multi-Label Segmentations with Preservation of Sharp Boundaries. 2022). Beyond the
// bounds of the data is one more label, and points on its border stay in the plane of it, in its edge, in its corner.
//
// The labels have their points in common: their meshes meet without gaps, bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/buffer.hpp"
#include "base/context.hpp"
#include "extract/detail/label_chunks.hpp"

namespace isoextract::extract {

class NetPoints {
 public:
  // How near a point gets to the sides of its cell, in steps of the grid: what keeps triangles from losing their area.
  static constexpr float kMargin = 0.02F;

  // Of all labels in `labels`, after so many rounds. What is not listed is one label more, whatever it is. In parallel;
  // the same for any number of threads. Fails where there is no memory, and where the context is cancelled.
  [[nodiscard]] static Result<NetPoints> make(const LabelChunks& labels, std::uint64_t relaxations,
                                              const Context& context, const std::string& what);

  // How many points there are.
  [[nodiscard]] std::uint64_t size() const { return offsets_.size(); }

  // From the corner to its point, in steps of the grid; 0 where there is none.
  [[nodiscard]] glm::vec3 offset(const glm::ivec3& corner) const;

  // Edges upward from corners along x, y, z that have a vertex in their middle, in the mesh of each label that has such
  // an edge: somewhere two voxels of one label touch along it and are joined at both of its ends, and all meshes are
  // to have the same triangles there. Null where a chunk has none.
  [[nodiscard]] const std::array<ChunkBits, 3>* middles(const glm::ivec3& origin) const;

 private:
  using RowBases = std::array<std::uint32_t, 64>;
  using Middles = std::array<ChunkBits, 3>;
  struct Moves;

  [[nodiscard]] Result<void> list_chunks(const LabelChunks& labels, const Context& context, const std::string& what);
  [[nodiscard]] Result<void> find_middles(const LabelChunks& labels, const Context& context, const std::string& what);
  [[nodiscard]] Result<void> relax(const LabelChunks& labels, std::uint64_t rounds, const Context& context,
                                   const std::string& what);
  [[nodiscard]] std::size_t number(std::size_t chunk, std::size_t row, int bit) const;

  std::vector<glm::ivec3> origins_;
  field::OriginIndex index_;
  Buffer<ChunkBits> used_;
  Buffer<RowBases> first_;  // the first point of a row
  Buffer<std::int32_t> middles_number_;
  Buffer<Middles> middles_;
  Buffer<glm::vec3> offsets_;
  std::vector<Reservation> memory_;
};

}  // namespace isoextract::extract

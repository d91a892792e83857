// Surface nets: smooth positions for the voxel corners where labels meet, shared by all labels.
//
// The net has one point in each grid cell whose eight samples have more than one label: the voxel corner in the middle
// of the cell. Points are connected if their cells share a face that has more than one label. Relaxation smooths the
// surface (net_relaxation.hpp). Then keep_volumes() gives each shell the volume of its voxels (net_volumes.hpp). A
// point stays within its cell (Gibson: Constrained Elastic Surface Nets. 1998).
//
// If at least two faces of the cell have three or more labels, a curve where these labels meet passes through it.
// Points on such a curve are connected with their neighbors on the curve only. So the curve is smooth, and surfaces
// that end on it do not displace it (Frisken: SurfaceNets for Multi-Label Segmentations with Preservation of Sharp
// Boundaries. 2022).
//
// The space beyond the data boundary counts as one more label. Points on the boundary stay in its plane, edge, or
// corner. All labels share the points, so their meshes meet without gaps, bit for bit.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/context.hpp"
#include "extract/detail/label_chunks.hpp"
#include "extract/detail/net_faces.hpp"
#include "extract/detail/net_grid.hpp"

namespace isoextract::extract {

class NetPoints {
 public:
  // Returns the net of all labels in `labels` after `relaxations` rounds of smoothing. All voxels without a label count
  // as one more label. `output_from_index`: the linear part of the map to the mesh's coordinates. Runs in parallel; the
  // result does not depend on the number of threads, nor on where `memory` puts the arrays. Fails as NetGrid::make()
  // and NetFaces::make() do.
  [[nodiscard]] static Result<NetPoints> make(const LabelChunks& labels, std::uint64_t relaxations,
                                              const glm::dmat3& output_from_index, NetMemory& memory);

  // Returns the bytes of so many points in so many chunks, without edges that have an extra vertex.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t points, std::uint64_t chunks) {
    return NetGrid::bytes(chunks) + chunks * sizeof(std::int32_t) + (points + 1) * sizeof(glm::vec3);
  }

  // Returns the most bytes that make() needs at a time for so many points, faces and chunks.
  [[nodiscard]] static std::uint64_t making_bytes(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks,
                                                  std::uint64_t relaxations);
  // Returns whether most of these bytes go to files.
  [[nodiscard]] static bool prefers_files(std::uint64_t points, std::uint64_t faces, std::uint64_t chunks,
                                          std::uint64_t relaxations, const Context& context);
  // Returns the part of these bytes that is always in memory.
  [[nodiscard]] static std::uint64_t list_bytes(std::uint64_t chunks, std::uint64_t relaxations);

  // Returns the number of points.
  [[nodiscard]] std::uint64_t size() const { return grid_.size(); }

  // Returns the number of the chunk at `origin`; negative if it has no points.
  [[nodiscard]] std::int32_t chunk(const glm::ivec3& origin) const { return grid_.find(origin); }

  // Returns the offset of a corner's point from the corner, in grid steps; 0 if the corner has no point. `chunk` is the
  // number of the corner's chunk.
  [[nodiscard]] glm::vec3 offset(std::int32_t chunk, const glm::ivec3& corner) const;

  // Returns the number of shells of each label, by rising label; an empty list if the points were not relaxed.
  [[nodiscard]] const std::vector<LabelShells>& shells() const { return shells_; }

  // Returns the edges of a chunk that have an extra vertex in their middle, by axis and lower corner; null if there are
  // none. Such an edge exists where two voxels of one label touch along it only, and are in one fan at both of its
  // ends. All labels get the vertex there, so that their meshes have the same triangles.
  [[nodiscard]] const std::array<ChunkBits, 3>* middles(const glm::ivec3& origin) const;

 private:
  using Middles = std::array<ChunkBits, 3>;

  // Does the work of make() once, and fails if memory runs out.
  [[nodiscard]] static Result<NetPoints> try_make(const LabelChunks& labels, std::uint64_t relaxations,
                                                  const glm::dmat3& output_from_index, NetMemory& memory);
  [[nodiscard]] Result<void> find_middles(const LabelChunks& labels, NetMemory& memory);

  NetGrid grid_;
  NetArray<std::int32_t> middles_number_;  // of each chunk of the grid
  NetArray<Middles> middles_;
  NetArray<glm::vec3> offsets_;  // of each point, then one unused element, since load() reads 16 bytes
  std::vector<LabelShells> shells_;
};

}  // namespace isoextract::extract

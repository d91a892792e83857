// What of a field voxels are made from: the region, its chunks, and its frame.
#pragma once

#include <optional>
#include <vector>

#include "extract/detail/voxel_chunks.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/extractor.hpp"

namespace isoextract::extract {

// The part of options.region within `box`. Fails with ErrorCode::input where that holds no sample.
[[nodiscard]] Result<field::IndexBox> voxel_region(const field::ScalarField& field, const field::IndexBox& box,
                                                   const ExtractOptions& options);

// The frame for voxels in `region`, of all those in `stored`.
[[nodiscard]] OutputFrame voxel_frame(const field::ScalarField& field, const ExtractOptions& options,
                                      const field::IndexBox& stored, const field::IndexBox& region);

// Where no voxel is out of reach: the region of sparse samples where none was asked for.
[[nodiscard]] field::IndexBox everywhere();

[[nodiscard]] inline bool is_in(const field::IndexBox& box, const glm::ivec3& p) {
  return glm::all(glm::greaterThanEqual(p, box.min)) && glm::all(glm::lessThanEqual(p, box.max));
}

// Sparse samples that are stored, of which there are some, and how far a region lets voxels go.
struct SparseReach {
  field::IndexBox stored;
  field::IndexBox region;
};
// `unbounded`: the background is inside. Fails as sparse_region() and voxel_region() do.
[[nodiscard]] Result<SparseReach> sparse_reach(const field::ScalarField& field, const field::SparseSamples& samples,
                                               const ExtractOptions& options, bool unbounded);
[[nodiscard]] OutputFrame sparse_voxel_frame(const field::ScalarField& field, const ExtractOptions& options,
                                             const SparseReach& reach);

// Chunks of a box of samples, the first of which begins at its lowest sample.
struct ChunkGrid {
  explicit ChunkGrid(const field::IndexBox& box)
      : size((box.dims() + glm::i64vec3(kVoxelChunk) - glm::i64vec3(1)) / glm::i64vec3(kVoxelChunk)) {}

  glm::i64vec3 size;

  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(size.x * size.y * size.z); }
  // The n-th, in chunk_order().
  [[nodiscard]] glm::ivec3 origin(std::size_t n) const {
    const auto number = static_cast<std::int64_t>(n);
    return kVoxelChunk * glm::ivec3(number % size.x, number / size.x % size.y, number / (size.x * size.y));
  }
};

// The bits of a chunk that lie in `box`, all of them set.
[[nodiscard]] ChunkBits bits_within(const glm::ivec3& origin, const field::IndexBox& box);

// Chunks of sparse samples in which voxels may be exposed, in chunk_order(): those of blocks and small tiles, the skins
// of large tiles, and what is around all that if `unbounded` (the background is inside). `is_inside` tells which tiles
// are, by number. Fails where there is no memory; `memory` is for the list.
[[nodiscard]] Result<std::vector<glm::ivec3>> sparse_chunks(const field::ScalarField& field,
                                                            const field::SparseSamples& samples,
                                                            const field::IndexBox& region, bool unbounded,
                                                            const std::vector<std::uint8_t>& tiles_inside,
                                                            const Context& context, Reservation& memory);

}  // namespace isoextract::extract

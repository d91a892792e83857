// Finds the region of a field that becomes voxels, its chunks, and its output frame.
#pragma once

#include <optional>
#include <vector>

#include "extract/detail/voxel_chunks.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/extractor.hpp"

namespace isoextract::extract {

// Returns the part of options.region within `box`, or `box` if options.region is not set. Fails with ErrorCode::input
// if this part is empty.
[[nodiscard]] Result<field::IndexBox> voxel_region(const field::ScalarField& field, const field::IndexBox& box,
                                                   const ExtractOptions& options);

// Returns the output frame for voxels in `region`; `stored` is the box of all stored voxels.
[[nodiscard]] OutputPlacement voxel_placement(const field::ScalarField& field, const ExtractOptions& options,
                                              const field::IndexBox& stored, const field::IndexBox& region);

// Returns a box that contains every possible voxel: the default region of sparse samples.
[[nodiscard]] field::IndexBox everywhere();

[[nodiscard]] inline bool is_in(const field::IndexBox& box, const glm::ivec3& p) {
  return glm::all(glm::greaterThanEqual(p, box.min)) && glm::all(glm::lessThanEqual(p, box.max));
}

// The box of the stored samples (not empty), and the box to which voxels are limited.
struct SparseBounds {
  field::IndexBox stored;
  field::IndexBox region;
};
// Returns the bounds of `samples`. `unbounded`: the background is inside. Fails as sparse_region() and voxel_region()
// do.
[[nodiscard]] Result<SparseBounds> sparse_bounds(const field::ScalarField& field, const field::SparseSamples& samples,
                                                 const ExtractOptions& options, bool unbounded);
[[nodiscard]] OutputPlacement sparse_voxel_placement(const field::ScalarField& field, const ExtractOptions& options,
                                                     const SparseBounds& reach);

// Returns the bounds of a label map, dense or sparse; sample (0, 0, 0) alone if no sample is stored. Fails as
// sparse_bounds() does.
[[nodiscard]] Result<SparseBounds> label_bounds(const field::ScalarField& field, const ExtractOptions& options);

// The chunks of a box of samples. Chunk 0 begins at the lowest sample, which becomes voxel 0.
struct ChunkGrid {
  explicit ChunkGrid(const field::IndexBox& box)
      : size((box.dims() + glm::i64vec3(kVoxelChunk) - glm::i64vec3(1)) / glm::i64vec3(kVoxelChunk)) {}

  glm::i64vec3 size;

  [[nodiscard]] std::size_t count() const { return static_cast<std::size_t>(size.x * size.y * size.z); }
  // Returns the origin of chunk n, in chunk_order(), relative to the lowest sample.
  [[nodiscard]] glm::ivec3 origin(std::size_t n) const {
    const auto number = static_cast<std::int64_t>(n);
    return kVoxelChunk * glm::ivec3(number % size.x, number / size.x % size.y, number / (size.x * size.y));
  }
};

// Returns a chunk whose bits are set for the voxels in `box`.
[[nodiscard]] ChunkBits bits_within(const glm::ivec3& origin, const field::IndexBox& box);

// Returns the chunks of sparse samples in which voxel faces may be exposed, in chunk_order(). These are the chunks of
// blocks and small tiles (below 64 samples a side), and of the skins of larger tiles on the other side than the
// background. If the background is inside (`unbounded`), adds the skin of a limited region, and the neighbors of all
// these chunks. `tiles_inside` tells for each tile whether it is inside. Fails if memory runs out; `memory` receives
// the reservation of the list.
[[nodiscard]] Result<std::vector<glm::ivec3>> sparse_chunks(const field::ScalarField& field,
                                                            const field::SparseSamples& samples,
                                                            const field::IndexBox& region, bool unbounded,
                                                            const std::vector<std::uint8_t>& tiles_inside,
                                                            const Context& context, Reservation& memory);

}  // namespace isoextract::extract

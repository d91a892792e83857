// The voxels of all labels: for each chunk, the bits of each label in it.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "extract/detail/voxel_chunks.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::extract {

// The voxels of one label in one chunk.
struct LabelChunk {
  std::int64_t label = 0;
  glm::ivec3 origin{0};
  const ChunkBits* bits = nullptr;  // owned by the caller
  std::uint64_t rows = 0;           // the rows that have voxels, as bits by chunk_row()
};

class LabelChunks {
 public:
  // Returns the label of all voxels in an unlisted chunk, or nullopt if they have none. A null function means that no
  // unlisted chunk has labels.
  using Unlisted = std::function<std::optional<std::int64_t>(const glm::ivec3& origin)>;

  // `chunks` are in chunk_order(), with one entry for each label of a chunk. All voxels are in `bounds`. `memory` is
  // the reservation of bytes().
  LabelChunks(std::vector<LabelChunk> chunks, Unlisted unlisted, const field::IndexBox& bounds, Reservation memory);

  // Returns the bytes of the list and its index.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chunks);

  [[nodiscard]] const std::vector<LabelChunk>& chunks() const { return chunks_; }
  [[nodiscard]] const field::IndexBox& bounds() const { return bounds_; }

  // Returns the entries of a chunk; an empty span if the chunk is not listed.
  [[nodiscard]] std::span<const LabelChunk> at(const glm::ivec3& origin) const;
  // Returns the label of a chunk that is not listed.
  [[nodiscard]] std::optional<std::int64_t> unlisted(const glm::ivec3& origin) const {
    return unlisted_ ? unlisted_(origin) : std::nullopt;
  }

  // Returns the label of a voxel, nullopt if it has none.
  [[nodiscard]] std::optional<std::int64_t> label_at(const glm::ivec3& voxel) const;
  // Returns the bits of one label in a chunk, listed or not.
  [[nodiscard]] const ChunkBits& bits(std::int64_t label, const glm::ivec3& origin) const;
  [[nodiscard]] bool has(std::int64_t label, const glm::ivec3& voxel) const {
    return (bits(label, chunk_origin(voxel))[chunk_row(voxel.y, voxel.z)] >> (voxel.x & 63) & 1) != 0;
  }

 private:
  std::vector<LabelChunk> chunks_;
  Unlisted unlisted_;
  field::IndexBox bounds_;
  Reservation memory_;
  field::OriginIndex index_;  // the first entry of each chunk
};

}  // namespace isoextract::extract

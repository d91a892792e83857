// Where the voxels of all labels are: for each chunk, the bits of each label in it.
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
  const ChunkBits* bits = nullptr;  // whoever found them keeps them
};

class LabelChunks {
 public:
  // The label that all of a chunk has that is not listed; nothing for none. Null: there are no such chunks.
  using Unlisted = std::function<std::optional<std::int64_t>(const glm::ivec3& origin)>;

  // `chunks` in chunk_order(), each label of a chunk once. Voxels are in `bounds` only. `memory` is for what bytes()
  // says.
  LabelChunks(std::vector<LabelChunk> chunks, Unlisted unlisted, const field::IndexBox& bounds, Reservation memory);

  // What the list and its index take.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chunks);

  [[nodiscard]] const std::vector<LabelChunk>& chunks() const { return chunks_; }
  [[nodiscard]] const field::IndexBox& bounds() const { return bounds_; }

  // The labels listed of a chunk; none where it is not listed.
  [[nodiscard]] std::span<const LabelChunk> at(const glm::ivec3& origin) const;
  // Of a chunk that is not listed.
  [[nodiscard]] std::optional<std::int64_t> unlisted(const glm::ivec3& origin) const {
    return unlisted_ ? unlisted_(origin) : std::nullopt;
  }

  // The bits of one label in a chunk.
  [[nodiscard]] const ChunkBits& bits(std::int64_t label, const glm::ivec3& origin) const;
  [[nodiscard]] bool has(std::int64_t label, const glm::ivec3& voxel) const {
    return (bits(label, chunk_origin(voxel))[chunk_row(voxel.y, voxel.z)] >> (voxel.x & 63) & 1) != 0;
  }

 private:
  std::vector<LabelChunk> chunks_;
  Unlisted unlisted_;
  field::IndexBox bounds_;
  Reservation memory_;
  field::OriginIndex index_;  // the first entry of a chunk
};

}  // namespace isoextract::extract

#include "extract/detail/label_chunks.hpp"

#include <utility>

namespace isoextract::extract {

LabelChunks::LabelChunks(std::vector<LabelChunk> chunks, Unlisted unlisted, const field::IndexBox& bounds,
                         Reservation memory)
    : chunks_(std::move(chunks)),
      unlisted_(std::move(unlisted)),
      bounds_(bounds),
      memory_(std::move(memory)),
      index_(chunks_.size()) {
  for (std::size_t c = 0; c < chunks_.size(); ++c) {
    if (c == 0 || chunks_[c].origin != chunks_[c - 1].origin) {
      index_.insert(chunks_[c].origin, static_cast<std::int32_t>(c));
    }
  }
}

std::uint64_t LabelChunks::bytes(std::uint64_t chunks) {
  return VoxelChunks::bytes(chunks) + chunks * (sizeof(LabelChunk) - sizeof(VoxelChunk));
}

std::span<const LabelChunk> LabelChunks::at(const glm::ivec3& origin) const {
  const std::int32_t first = index_.find(origin);
  if (first < 0) return {};
  const auto begin = static_cast<std::size_t>(first);
  std::size_t end = begin + 1;
  while (end < chunks_.size() && chunks_[end].origin == origin) ++end;
  return std::span(chunks_).subspan(begin, end - begin);
}

std::optional<std::int64_t> LabelChunks::label_at(const glm::ivec3& voxel) const {
  const std::span<const LabelChunk> listed = at(chunk_origin(voxel));
  if (listed.empty()) return unlisted(chunk_origin(voxel));
  for (const LabelChunk& chunk : listed) {
    if (((*chunk.bits)[chunk_row(voxel.y, voxel.z)] >> (voxel.x & 63) & 1) != 0) return chunk.label;
  }
  return std::nullopt;
}

const ChunkBits& LabelChunks::bits(std::int64_t label, const glm::ivec3& origin) const {
  const std::span<const LabelChunk> listed = at(origin);
  for (const LabelChunk& chunk : listed) {
    if (chunk.label == label) return *chunk.bits;
  }
  return listed.empty() && unlisted(origin) == label ? full_chunk() : empty_chunk();
}

}  // namespace isoextract::extract

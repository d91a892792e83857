#include "extract/detail/voxel_chunks.hpp"

#include <bit>
#include <utility>

namespace isoextract::extract {
namespace {

constexpr ChunkBits filled(std::uint64_t word) {
  ChunkBits bits{};
  for (std::uint64_t& row : bits) row = word;
  return bits;
}

constexpr ChunkBits kFullChunk = filled(kAllBits);
constexpr ChunkBits kEmptyChunk = filled(0);

}  // namespace

const ChunkBits& full_chunk() { return kFullChunk; }
const ChunkBits& empty_chunk() { return kEmptyChunk; }

std::uint64_t rows_with_voxels(const ChunkBits& bits) {
  std::uint64_t rows = 0;
  for (std::size_t row = 0; row < bits.size(); ++row) rows |= std::uint64_t{bits[row] != 0 ? 1U : 0U} << row;
  return rows;
}

VoxelChunks::VoxelChunks(std::vector<VoxelChunk> chunks, Unlisted unlisted, std::shared_ptr<const void> owner,
                         Reservation memory)
    : chunks_(std::move(chunks)),
      unlisted_(std::move(unlisted)),
      owner_(std::move(owner)),
      memory_(std::move(memory)),
      index_(chunks_.size()) {
  for (std::size_t c = 0; c < chunks_.size(); ++c) index_.insert(chunks_[c].origin, static_cast<std::int32_t>(c));
}

std::uint64_t VoxelChunks::bytes(std::uint64_t chunks) {
  constexpr std::uint64_t kSlot = sizeof(glm::ivec3) + sizeof(std::int32_t);  // of field::OriginIndex
  return chunks * sizeof(VoxelChunk) + std::bit_ceil(2 * chunks + 1) * kSlot;
}

unsigned VoxelChunks::pattern(const glm::ivec3& p) const {
  unsigned pattern = 0;
  for (int n = 0; n < 8; ++n) {
    const glm::ivec3 voxel = p - 1 + glm::ivec3(n & 1, n >> 1 & 1, n >> 2);
    if (inside(voxel)) pattern |= 1U << n;
  }
  return pattern;
}

}  // namespace isoextract::extract

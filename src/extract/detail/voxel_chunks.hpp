// Inside bits of voxels, in chunks of 64x8x8. Lists all chunks that may contain an exposed face, and perhaps others.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <tuple>
#include <vector>

#include <glm/glm.hpp>

#include "base/memory_budget.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::extract {

inline constexpr glm::ivec3 kVoxelChunk{64, 8, 8};

// Bit x of word z << 3 | y.
using ChunkBits = std::array<std::uint64_t, 64>;

inline constexpr std::uint64_t kAllBits = ~std::uint64_t{0};
[[nodiscard]] inline std::size_t chunk_row(int y, int z) { return static_cast<std::size_t>((z & 7) << 3 | (y & 7)); }
[[nodiscard]] inline glm::ivec3 chunk_origin(const glm::ivec3& p) { return {p.x & ~63, p.y & ~7, p.z & ~7}; }

[[nodiscard]] const ChunkBits& full_chunk();   // all voxels inside
[[nodiscard]] const ChunkBits& empty_chunk();  // all voxels outside

// Returns the rows that have inside voxels, as bits by chunk_row().
[[nodiscard]] std::uint64_t rows_with_voxels(const ChunkBits& bits);

struct VoxelChunk {
  glm::ivec3 origin;                // a multiple of kVoxelChunk
  const ChunkBits* bits = nullptr;  // not owned
};

// Returns the sort key of chunks: by z, then y, then x.
[[nodiscard]] inline auto chunk_order(const glm::ivec3& origin) { return std::tuple(origin.z, origin.y, origin.x); }

class VoxelChunks {
 public:
  // Returns whether all voxels of an unlisted chunk are inside. A null function means that none is.
  using Unlisted = std::function<bool(const glm::ivec3& origin)>;

  VoxelChunks() = default;
  // `chunks` are in chunk_order(), without duplicates. `owner` keeps their bits alive. `memory` is the reservation of
  // bytes(), without the bits.
  VoxelChunks(std::vector<VoxelChunk> chunks, Unlisted unlisted, std::shared_ptr<const void> owner, Reservation memory);

  // Returns the bytes of the list and its index.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chunks);

  [[nodiscard]] const std::vector<VoxelChunk>& chunks() const { return chunks_; }

  // Returns the bits of the chunk at `origin`, listed or not.
  [[nodiscard]] const ChunkBits& at(const glm::ivec3& origin) const {
    const std::int32_t number = index_.find(origin);
    if (number >= 0) return *chunks_[static_cast<std::size_t>(number)].bits;
    return unlisted_ && unlisted_(origin) ? full_chunk() : empty_chunk();
  }

  [[nodiscard]] bool lists(const glm::ivec3& origin) const { return index_.find(origin) >= 0; }

  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    return (at(chunk_origin(p))[chunk_row(p.y, p.z)] >> (p.x & 63) & 1) != 0;
  }

  // Returns the pattern (corner_fans.hpp) of the eight voxels around corner `p`, the lower corner of voxel `p`.
  [[nodiscard]] unsigned pattern(const glm::ivec3& p) const;

 private:
  std::vector<VoxelChunk> chunks_;
  Unlisted unlisted_;
  std::shared_ptr<const void> owner_;
  Reservation memory_;
  field::OriginIndex index_;
};

}  // namespace isoextract::extract

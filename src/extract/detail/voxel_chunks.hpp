// Which voxels are inside, one bit each, in boxes of 64 x 8 x 8. Only boxes that a face may be in are listed.
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

[[nodiscard]] const ChunkBits& full_chunk();   // all inside
[[nodiscard]] const ChunkBits& empty_chunk();  // all outside

struct VoxelChunk {
  glm::ivec3 origin;                // a multiple of kVoxelChunk
  const ChunkBits* bits = nullptr;  // whoever made the chunk keeps them
};

// z first, then y, then x.
[[nodiscard]] inline auto chunk_order(const glm::ivec3& origin) { return std::tuple(origin.z, origin.y, origin.x); }

class VoxelChunks {
 public:
  // Whether all of a chunk that is not listed is inside. Null: none is.
  using Unlisted = std::function<bool(const glm::ivec3& origin)>;

  VoxelChunks() = default;
  // `chunks` are in chunk_order(), each place once. `memory` is for them (bytes()) and for their bits, which `owner`
  // keeps.
  VoxelChunks(std::vector<VoxelChunk> chunks, Unlisted unlisted, std::shared_ptr<const void> owner, Reservation memory);

  // What the list and its index take.
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t chunks);

  [[nodiscard]] const std::vector<VoxelChunk>& chunks() const { return chunks_; }

  // Of any place.
  [[nodiscard]] const ChunkBits& at(const glm::ivec3& origin) const {
    const std::int32_t number = index_.find(origin);
    if (number >= 0) return *chunks_[static_cast<std::size_t>(number)].bits;
    return unlisted_ && unlisted_(origin) ? full_chunk() : empty_chunk();
  }

  [[nodiscard]] bool lists(const glm::ivec3& origin) const { return index_.find(origin) >= 0; }

  [[nodiscard]] bool inside(const glm::ivec3& p) const {
    return (at(chunk_origin(p))[chunk_row(p.y, p.z)] >> (p.x & 63) & 1) != 0;
  }

  // Of the eight voxels around corner `p`, whose upper one is voxel `p`, as in corner_fans.hpp.
  [[nodiscard]] unsigned pattern(const glm::ivec3& p) const;

 private:
  std::vector<VoxelChunk> chunks_;
  Unlisted unlisted_;
  std::shared_ptr<const void> owner_;
  Reservation memory_;
  field::OriginIndex index_;
};

}  // namespace isoextract::extract

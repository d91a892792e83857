// Inside bits of the voxels around grid corners, for 64 corners of a row at once. Corner p is the lower corner of voxel
// p. The eight voxels around a corner are numbered as in corner_fans.hpp.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "extract/detail/voxel_chunks.hpp"

namespace isoextract::extract {

// Bit b of word n is set if voxel n of the eight around corner b of a row is inside.
using CornerWords = std::array<std::uint64_t, 8>;

// The chunks that contain the voxels around the corners of a chunk. Chunk 7 is the chunk itself; chunk n is one step
// lower along each axis bit that 7 - n has.
using NearChunks = std::array<const ChunkBits*, 8>;

// Returns the step from a chunk to the chunk one step higher along each axis bit of `n`.
[[nodiscard]] inline glm::ivec3 chunk_step(int n) { return kVoxelChunk * glm::ivec3(n & 1, n >> 1 & 1, n >> 2); }

// Returns the words of the row of corners at `y` and `z` in a chunk.
[[nodiscard]] inline CornerWords corner_words(const NearChunks& near, int y, int z) {
  CornerWords words;
  for (int n = 0; n < 8; n += 2) {
    const int voxel_y = y - 1 + (n >> 1 & 1);
    const int voxel_z = z - 1 + (n >> 2);
    const std::size_t chunk = (voxel_y < 0 ? 0U : 2U) | (voxel_z < 0 ? 0U : 4U);
    const std::uint64_t upper = (*near[chunk | 1])[chunk_row(voxel_y, voxel_z)];
    const std::uint64_t before = (*near[chunk])[chunk_row(voxel_y, voxel_z)];
    words[static_cast<std::size_t>(n)] = upper << 1 | before >> 63;
    words[static_cast<std::size_t>(n) + 1] = upper;
  }
  return words;
}

[[nodiscard]] inline unsigned pattern_at(const CornerWords& words, int bit) {
  unsigned pattern = 0;
  for (std::size_t n = 0; n < 8; ++n) pattern |= static_cast<unsigned>(words[n] >> bit & 1) << n;
  return pattern;
}

// Returns the four voxels around each corner that lie on one side of it along an axis (`side` 0: lower, 1: upper). They
// surround the edge from the corner to that side. The first and the last voxel are diagonally opposite.
[[nodiscard]] inline std::array<std::uint64_t, 4> words_on_side(const CornerWords& words, std::size_t axis,
                                                                std::size_t side) {
  const std::size_t u = axis == 0 ? 2 : 1;
  const std::size_t v = axis == 2 ? 2 : 4;
  const std::size_t low = side << axis;
  return {words[low], words[low | u], words[low | v], words[low | u | v]};
}

// Returns a bit for each corner where two of the four voxels touch along their common edge only.
[[nodiscard]] inline std::uint64_t diagonal(const std::array<std::uint64_t, 4>& four) {
  return (four[0] ^ four[1]) & (four[0] ^ four[2]) & ~(four[0] ^ four[3]);
}

// Returns a bit for each corner whose voxels (four on a side, or all eight) are neither all inside nor all outside.
template <std::size_t kVoxels>
[[nodiscard]] inline std::uint64_t mixed(const std::array<std::uint64_t, kVoxels>& words) {
  std::uint64_t some = words[0];
  std::uint64_t all = words[0];
  for (std::size_t n = 1; n < kVoxels; ++n) {
    some |= words[n];
    all &= words[n];
  }
  return some & ~all;
}

// Returns a bit for each corner that ends an edge along which voxels touch without a common face.
[[nodiscard]] inline std::uint64_t contacts(const CornerWords& words) {
  std::uint64_t found = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t side = 0; side < 2; ++side) found |= diagonal(words_on_side(words, axis, side));
  }
  return found;
}

}  // namespace isoextract::extract

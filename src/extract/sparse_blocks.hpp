// Finding things by place in a sparse grid, and the 512 inside bits of blocks.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "extract/inside_test.hpp"
#include "field/samples.hpp"

namespace isoextract {

// A hash table from block origins (or tile origins) to their numbers in a list. Open addressing, at most half full.
class OriginIndex {
 public:
  OriginIndex() = default;
  explicit OriginIndex(std::size_t count);

  void insert(const glm::ivec3& origin, std::int32_t number);

  // -1 if there is none.
  [[nodiscard]] std::int32_t find(const glm::ivec3& origin) const;

 private:
  struct Slot {
    glm::ivec3 origin;
    std::int32_t number;
  };
  [[nodiscard]] std::size_t slot_of(const glm::ivec3& origin) const;

  std::vector<Slot> slots_;
};

// The block origin of a sample.
[[nodiscard]] inline glm::ivec3 block_origin(const glm::ivec3& p) { return p & ~(SparseBlock::kSize - 1); }

// Where a sample lies in its block's values and bits: word x, bit y << 3 | z.
[[nodiscard]] inline int block_offset(const glm::ivec3& p) { return (p.x & 7) << 6 | (p.y & 7) << 3 | (p.z & 7); }

class SparseLookup {
 public:
  explicit SparseLookup(const SparseSamples& samples);

  // The number of the stored block, or -1.
  [[nodiscard]] std::int32_t block(const glm::ivec3& origin) const { return blocks_.find(origin); }

  // The one value of a place of block size that has no stored block.
  [[nodiscard]] double constant(const glm::ivec3& origin) const;

 private:
  const SparseSamples& samples_;
  OriginIndex blocks_;
  std::vector<std::pair<int, OriginIndex>> tiles_;  // by size
};

// The box of all blocks and tiles; empty if there are none.
[[nodiscard]] IndexBox stored_box(const SparseSamples& samples);

// 512 bits, in the order of a block's values.
using BlockBits = std::array<std::uint64_t, 8>;

// What listing the skins of the tiles that are not on the background's side will need in memory, about. The mesh on
// them is counted exactly later.
[[nodiscard]] std::uint64_t tile_skin_bytes(const SparseSamples& samples, const InsideRule& rule,
                                            const ValueScale& scale);

// Places without a stored block around which both sides may occur: those that share a cell with a stored block, and the
// skins of tiles that are not on the background's side. Sorted; a place may be named that turns out to be one-sided.
[[nodiscard]] std::vector<glm::ivec3> unstored_places(const SparseSamples& samples, const SparseLookup& lookup,
                                                      const InsideRule& rule, const ValueScale& scale);

// The bits of samples p + step for all samples p of the block at the low corner of a 2 x 2 x 2 group. `group[n]` are
// the bits of the block that lies n & 1, n >> 1 & 1, n >> 2 & 1 blocks along x, y, z; `step` has the same form.
[[nodiscard]] std::uint64_t shifted_word(const std::array<const BlockBits*, 8>& group, int step, int x);

}  // namespace isoextract

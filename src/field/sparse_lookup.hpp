// Finding blocks and tiles of a sparse grid by their place.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

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

}  // namespace isoextract

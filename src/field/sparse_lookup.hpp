// Finding blocks and tiles of a sparse grid by their place.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "field/samples.hpp"

namespace isoextract::field {

// A hash table from origins (of blocks, tiles, nodes) to their numbers in a list. Open addressing, at most half full.
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

// What is stored at each place of block size.
class SparseLookup {
 public:
  // A cube of places, 128 samples a side, in which a block or a small tile is stored.
  struct Node {
    static constexpr int kPlaces = 16;                               // a side
    static constexpr int kSize = kPlaces * SparseBlock::kSize;       // samples a side
    glm::ivec3 origin;                                               // a multiple of kSize in every axis
    std::array<std::int32_t, kPlaces * kPlaces * kPlaces> contents;  // as place() tells them; z fastest

    // Of a place in the node, by its origin.
    [[nodiscard]] static std::size_t slot(const glm::ivec3& place) {
      const glm::ivec3 p = place >> 3 & (kPlaces - 1);
      return static_cast<std::size_t>(p.x << 8 | p.y << 4 | p.z);
    }
  };

  // The nodes that samples need, sorted. Each takes sizeof(Node): samples far apart need much more than themselves.
  [[nodiscard]] static std::vector<glm::ivec3> node_origins(const SparseSamples& samples);

  explicit SparseLookup(const SparseSamples& samples) : SparseLookup(samples, node_origins(samples)) {}
  SparseLookup(const SparseSamples& samples, const std::vector<glm::ivec3>& node_origins);

  // The number of the stored block, kBackground, or tile_place() of a tile.
  [[nodiscard]] std::int32_t place(const glm::ivec3& origin) const {
    const std::int32_t node = nodes_.find(origin & ~(Node::kSize - 1));
    return node >= 0 ? node_list_[static_cast<std::size_t>(node)].contents[Node::slot(origin)] : large_tile(origin);
  }
  // Of the place at `origin` and those at +1 along x, y, z: entry n is n & 1, n >> 1 & 1, n >> 2 & 1 places away.
  using Group = std::array<std::int32_t, 8>;
  [[nodiscard]] Group group(const glm::ivec3& origin) const;

  static constexpr std::int32_t kBackground = -1;
  [[nodiscard]] static std::int32_t tile_place(std::size_t tile) { return -2 - static_cast<std::int32_t>(tile); }

  // And back, for a place that is a tile's.
  [[nodiscard]] static std::size_t tile_of(std::int32_t place) { return static_cast<std::size_t>(-2 - place); }

  // The one value of such a place without a block.
  [[nodiscard]] double constant_of(std::int32_t place) const {
    return place == kBackground ? samples_.background : samples_.tiles[tile_of(place)].value;
  }

  // The number of the stored block, or -1.
  [[nodiscard]] std::int32_t block(const glm::ivec3& origin) const { return std::max(place(origin), -1); }

  // The one value of a place of block size that has no stored block.
  [[nodiscard]] double constant(const glm::ivec3& origin) const { return constant_of(place(origin)); }

  [[nodiscard]] const std::vector<Node>& nodes() const { return node_list_; }

 private:
  [[nodiscard]] std::int32_t large_tile(const glm::ivec3& origin) const;

  const SparseSamples& samples_;
  OriginIndex nodes_;
  std::vector<Node> node_list_;
  std::vector<std::pair<int, OriginIndex>> large_tiles_;  // those of a node's size and more, by size
};

}  // namespace isoextract::field

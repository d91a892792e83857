// Finds the block or tile of a sparse grid at a position.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "field/samples.hpp"

namespace isoextract::field {

// A hash table from origins (of blocks, tiles or nodes) to their indices in a list. Open addressing, at most half full.
class OriginIndex {
 public:
  OriginIndex() = default;
  // Makes room for `count` origins, each a multiple of 8 along every axis.
  explicit OriginIndex(std::size_t count);

  // Adds an origin that the table does not contain yet. `number` is its index in the list and must not be -1.
  void insert(const glm::ivec3& origin, std::int32_t number);

  // Returns -1 if the table does not contain `origin`.
  [[nodiscard]] std::int32_t find(const glm::ivec3& origin) const;

 private:
  struct Slot {
    glm::ivec3 origin;
    std::int32_t number;
  };
  [[nodiscard]] std::size_t slot_of(const glm::ivec3& origin) const;

  std::vector<Slot> slots_;
};

// Finds the tile that covers a place. A place is a cube of 8^3 samples; its origin is a multiple of 8 along each axis.
// Takes at most 64 bytes for each indexed tile.
class TileIndex {
 public:
  TileIndex() = default;
  // Indexes the tiles with at least `least_size` samples along each axis.
  TileIndex(const std::vector<SparseTile>& tiles, int least_size);

  // Returns the index in `tiles` of the tile that covers the place at `origin`, or -1.
  [[nodiscard]] std::int32_t find(const glm::ivec3& origin) const;

 private:
  std::vector<std::pair<int, OriginIndex>> by_size_;
};

// Returns the origin of the block that contains sample `p`.
[[nodiscard]] inline glm::ivec3 block_origin(const glm::ivec3& p) { return p & ~(SparseBlock::kSize - 1); }

// Returns the index of sample `p` in its block's values: x << 6 | y << 3 | z.
[[nodiscard]] inline int block_offset(const glm::ivec3& p) { return (p.x & 7) << 6 | (p.y & 7) << 3 | (p.z & 7); }

// Finds what is stored at each block-sized place: an 8^3 cube with its origin at multiples of 8.
class SparseLookup {
 public:
  // 16^3 places (128 samples along each axis). At least one place is a block, or lies in a tile smaller than a node.
  struct Node {
    static constexpr int kPlaces = 16;                               // along each axis
    static constexpr int kSize = kPlaces * SparseBlock::kSize;       // samples along each axis
    glm::ivec3 origin;                                               // a multiple of kSize along every axis
    std::array<std::int32_t, kPlaces * kPlaces * kPlaces> contents;  // results of place(), z fastest

    // Returns the index in `contents` of the place at this origin.
    [[nodiscard]] static std::size_t slot(const glm::ivec3& place) {
      const glm::ivec3 p = place >> 3 & (kPlaces - 1);
      return static_cast<std::size_t>(p.x << 8 | p.y << 4 | p.z);
    }
  };

  // Returns the sorted origins of the nodes that `samples` needs. A node takes sizeof(Node) bytes, so scattered samples
  // need far more memory than their values.
  [[nodiscard]] static std::vector<glm::ivec3> node_origins(const SparseSamples& samples);

  // Returns the bytes of the nodes. The caller reserves them.
  [[nodiscard]] static std::uint64_t bytes(const SparseSamples& samples) {
    return node_origins(samples).size() * sizeof(Node);
  }

  // `samples` must outlive this object. `node_origins` must be node_origins(samples).
  explicit SparseLookup(const SparseSamples& samples) : SparseLookup(samples, node_origins(samples)) {}
  SparseLookup(const SparseSamples& samples, const std::vector<glm::ivec3>& node_origins);

  // Returns what covers the place at `origin`: the index of a stored block, place_of_tile() of a tile, or kBackground.
  [[nodiscard]] std::int32_t place(const glm::ivec3& origin) const {
    const std::int32_t node = nodes_.find(origin & ~(Node::kSize - 1));
    return node >= 0 ? node_list_[static_cast<std::size_t>(node)].contents[Node::slot(origin)] : large_tile(origin);
  }
  // The results of place() for `origin` and its neighbors: entry n is (n & 1, n >> 1 & 1, n >> 2 & 1) places further
  // along x, y and z.
  using Group = std::array<std::int32_t, 8>;
  [[nodiscard]] Group group(const glm::ivec3& origin) const;

  static constexpr std::int32_t kBackground = -1;
  [[nodiscard]] static std::int32_t place_of_tile(std::size_t tile) { return -2 - static_cast<std::int32_t>(tile); }

  // Inverts place_of_tile().
  [[nodiscard]] static std::size_t tile_of(std::int32_t content) { return static_cast<std::size_t>(-2 - content); }

  // Returns the value of the tile or background that place() returned.
  [[nodiscard]] double constant_of(std::int32_t content) const {
    return content == kBackground ? samples_.background : samples_.tiles[tile_of(content)].value;
  }

  // Returns the index of the stored block, or -1.
  [[nodiscard]] std::int32_t block(const glm::ivec3& origin) const { return std::max(place(origin), -1); }

  // Returns the constant value of the place at `origin`, which must have no block.
  [[nodiscard]] double constant(const glm::ivec3& origin) const { return constant_of(place(origin)); }

  [[nodiscard]] const std::vector<Node>& nodes() const { return node_list_; }

 private:
  [[nodiscard]] std::int32_t large_tile(const glm::ivec3& origin) const {
    const std::int32_t tile = large_tiles_.find(origin);
    return tile >= 0 ? place_of_tile(static_cast<std::size_t>(tile)) : kBackground;
  }

  const SparseSamples& samples_;
  OriginIndex nodes_;
  std::vector<Node> node_list_;
  TileIndex large_tiles_;  // of a node's size or more
};

}  // namespace isoextract::field

#include "field/sparse_lookup.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

#include "base/hash.hpp"

namespace isoextract::field {
namespace {

constexpr std::int32_t kEmpty = -1;

}  // namespace

OriginIndex::OriginIndex(std::size_t count) : slots_(std::bit_ceil(2 * count + 1), Slot{glm::ivec3(0), kEmpty}) {}

std::size_t OriginIndex::slot_of(const glm::ivec3& origin) const {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) >> 3); };
  return hash_coordinates(part(origin.x), part(origin.y), part(origin.z)) & (slots_.size() - 1);
}

void OriginIndex::insert(const glm::ivec3& origin, std::int32_t number) {
  std::size_t slot = slot_of(origin);
  while (slots_[slot].number != kEmpty) slot = (slot + 1) & (slots_.size() - 1);
  slots_[slot] = {origin, number};
}

std::int32_t OriginIndex::find(const glm::ivec3& origin) const {
  if (slots_.empty()) return kEmpty;
  std::size_t slot = slot_of(origin);
  while (slots_[slot].number != kEmpty && slots_[slot].origin != origin) slot = (slot + 1) & (slots_.size() - 1);
  return slots_[slot].number;
}

TileIndex::TileIndex(const std::vector<SparseTile>& tiles, int least_size) {
  for (std::size_t t = 0; t < tiles.size(); ++t) {
    const SparseTile& tile = tiles[t];
    if (tile.size < least_size) continue;
    auto same_size = std::ranges::find(by_size_, tile.size, &std::pair<int, OriginIndex>::first);
    if (same_size == by_size_.end()) {
      const auto count = std::ranges::count(tiles, tile.size, &SparseTile::size);
      same_size = by_size_.insert(same_size, {tile.size, OriginIndex(static_cast<std::size_t>(count))});
    }
    same_size->second.insert(tile.origin, static_cast<std::int32_t>(t));
  }
}

std::int32_t TileIndex::find(const glm::ivec3& origin) const {
  for (const auto& [size, index] : by_size_) {
    // Tile sizes are powers of two.
    if (const std::int32_t tile = index.find(origin & ~(size - 1)); tile >= 0) return tile;
  }
  return -1;
}

namespace {

bool is_small(const SparseTile& tile) { return tile.size < SparseLookup::Node::kSize; }

}  // namespace

std::vector<glm::ivec3> SparseLookup::node_origins(const SparseSamples& samples) {
  std::vector<glm::ivec3> origins;
  // Consecutive entries of the lists mostly share a node.
  const auto add = [&](const glm::ivec3& p) {
    const glm::ivec3 origin = p & ~(Node::kSize - 1);
    if (origins.empty() || origins.back() != origin) origins.push_back(origin);
  };
  for (const SparseBlock& block : samples.blocks) add(block.origin);
  for (const SparseTile& tile : samples.tiles) {
    if (is_small(tile)) add(tile.origin);
  }
  std::ranges::sort(origins, {}, [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); });
  origins.erase(std::unique(origins.begin(), origins.end()), origins.end());
  return origins;
}

SparseLookup::SparseLookup(const SparseSamples& samples, const std::vector<glm::ivec3>& origins)
    : samples_(samples), large_tiles_(samples.tiles, Node::kSize) {
  nodes_ = OriginIndex(origins.size());
  node_list_.resize(origins.size());
  for (std::size_t n = 0; n < origins.size(); ++n) {
    nodes_.insert(origins[n], static_cast<std::int32_t>(n));
    node_list_[n].origin = origins[n];
    node_list_[n].contents.fill(kBackground);
  }

  Node* node = nullptr;  // the node that was used last
  const auto node_of = [&](const glm::ivec3& p) -> Node& {
    const glm::ivec3 origin = p & ~(Node::kSize - 1);
    if (node == nullptr || node->origin != origin) node = &node_list_[static_cast<std::size_t>(nodes_.find(origin))];
    return *node;
  };
  for (std::size_t b = 0; b < samples.blocks.size(); ++b) {
    const glm::ivec3& origin = samples.blocks[b].origin;
    node_of(origin).contents[Node::slot(origin)] = static_cast<std::int32_t>(b);
  }
  for (std::size_t t = 0; t < samples.tiles.size(); ++t) {
    const SparseTile& tile = samples.tiles[t];
    if (is_small(tile)) {
      Node& owner = node_of(tile.origin);
      for (int x = 0; x < tile.size; x += SparseBlock::kSize) {
        for (int y = 0; y < tile.size; y += SparseBlock::kSize) {
          for (int z = 0; z < tile.size; z += SparseBlock::kSize) {
            owner.contents[Node::slot(tile.origin + glm::ivec3(x, y, z))] = place_of_tile(t);
          }
        }
      }
    }
  }
}

SparseLookup::Group SparseLookup::group(const glm::ivec3& origin) const {
  constexpr int kSize = SparseBlock::kSize;
  Group group;
  const std::int32_t node = nodes_.find(origin & ~(Node::kSize - 1));
  const auto away = [](std::size_t n) { return glm::ivec3(n & 1, n >> 1 & 1, n >> 2); };
  if (node >= 0 && glm::all(glm::lessThan(origin & (Node::kSize - 1), glm::ivec3(Node::kSize - kSize)))) {
    const auto& contents = node_list_[static_cast<std::size_t>(node)].contents;
    for (std::size_t n = 0; n < 8; ++n) group[n] = contents[Node::slot(origin + kSize * away(n))];
  } else {
    for (std::size_t n = 0; n < 8; ++n) group[n] = place(origin + kSize * away(n));
  }
  return group;
}

}  // namespace isoextract::field

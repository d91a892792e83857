#include "field/sparse_lookup.hpp"

#include <algorithm>
#include <bit>

namespace isoextract {
namespace {

constexpr std::int32_t kEmpty = -1;

}  // namespace

OriginIndex::OriginIndex(std::size_t count) : slots_(std::bit_ceil(2 * count + 1), Slot{glm::ivec3(0), kEmpty}) {}

std::size_t OriginIndex::slot_of(const glm::ivec3& origin) const {
  const auto part = [](int v) { return static_cast<std::uint64_t>(static_cast<std::uint32_t>(v) >> 3); };
  std::uint64_t h = part(origin.x) * 0x9E3779B97F4A7C15ULL;
  h = (h ^ part(origin.y)) * 0xC2B2AE3D27D4EB4FULL;
  h = (h ^ part(origin.z)) * 0x9E3779B97F4A7C15ULL;
  return static_cast<std::size_t>(h ^ h >> 32) & (slots_.size() - 1);
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

SparseLookup::SparseLookup(const SparseSamples& samples) : samples_(samples), blocks_(samples.blocks.size()) {
  for (std::size_t b = 0; b < samples.blocks.size(); ++b) {
    blocks_.insert(samples.blocks[b].origin, static_cast<std::int32_t>(b));
  }
  for (const SparseTile& tile : samples.tiles) {
    if (std::ranges::none_of(tiles_, [&](const auto& entry) { return entry.first == tile.size; })) {
      const auto same_size = std::ranges::count(samples.tiles, tile.size, &SparseTile::size);
      tiles_.emplace_back(tile.size, OriginIndex(static_cast<std::size_t>(same_size)));
    }
  }
  for (std::size_t t = 0; t < samples.tiles.size(); ++t) {
    const SparseTile& tile = samples.tiles[t];
    const auto entry = std::ranges::find(tiles_, tile.size, &std::pair<int, OriginIndex>::first);
    entry->second.insert(tile.origin, static_cast<std::int32_t>(t));
  }
}

double SparseLookup::constant(const glm::ivec3& origin) const {
  for (const auto& [size, index] : tiles_) {
    // Tile sizes are powers of two.
    if (const std::int32_t tile = index.find(origin & ~(size - 1)); tile >= 0) return samples_.tiles[tile].value;
  }
  return samples_.background;
}

}  // namespace isoextract

#include "extract/sparse_blocks.hpp"

#include <algorithm>
#include <limits>
#include <tuple>

namespace isoextract {
namespace {

constexpr int kSize = SparseBlock::kSize;

// Appends the places of block size whose 2 x 2 x 2 group is partly in the tile and partly not.
void add_tile_skin(const SparseTile& tile, std::vector<glm::ivec3>& places) {
  const int blocks = tile.size / kSize;
  const auto on_skin = [&](int b) { return b == -1 || b == blocks - 1; };
  for (int x = -1; x < blocks; ++x) {
    for (int y = -1; y < blocks; ++y) {
      const int step = on_skin(x) || on_skin(y) ? 1 : blocks;  // only the two ends along z, where x and y are within
      for (int z = -1; z < blocks; z += step) places.push_back(tile.origin + kSize * glm::ivec3(x, y, z));
    }
  }
}

}  // namespace

IndexBox stored_box(const SparseSamples& samples) {
  IndexBox box{glm::ivec3(std::numeric_limits<int>::max()), glm::ivec3(std::numeric_limits<int>::min())};
  const auto add = [&](const glm::ivec3& origin, int size) {
    box.min = glm::min(box.min, origin);
    box.max = glm::max(box.max, origin + (size - 1));
  };
  for (const SparseBlock& block : samples.blocks) add(block.origin, kSize);
  for (const SparseTile& tile : samples.tiles) add(tile.origin, tile.size);
  return box;
}

std::uint64_t tile_skin_bytes(const SparseSamples& samples, const InsideRule& rule, const ValueScale& scale) {
  constexpr std::uint64_t kBytesAPlace = 128;
  const bool background_inside = rule(scale(samples.background));
  std::uint64_t places = 0;
  for (const SparseTile& tile : samples.tiles) {
    if (rule(scale(tile.value)) == background_inside) continue;
    const auto blocks = static_cast<std::uint64_t>(tile.size / kSize);
    places += (blocks + 1) * (blocks + 1) * (blocks + 1) - (blocks - 1) * (blocks - 1) * (blocks - 1);
  }
  return places * kBytesAPlace;
}

std::vector<glm::ivec3> unstored_places(const SparseSamples& samples, const SparseLookup& lookup,
                                        const InsideRule& rule, const ValueScale& scale) {
  std::vector<glm::ivec3> places;
  for (const SparseBlock& block : samples.blocks) {
    for (int d = 1; d < 8; ++d) {
      const glm::ivec3 place = block.origin - kSize * glm::ivec3(d & 1, d >> 1 & 1, d >> 2 & 1);
      if (lookup.block(place) < 0) places.push_back(place);
    }
  }
  const bool background_inside = rule(scale(samples.background));
  std::vector<glm::ivec3> skin;
  for (const SparseTile& tile : samples.tiles) {
    if (rule(scale(tile.value)) != background_inside) add_tile_skin(tile, skin);
  }
  std::ranges::copy_if(skin, std::back_inserter(places), [&](const glm::ivec3& p) { return lookup.block(p) < 0; });
  const auto key = [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); };
  std::ranges::sort(places, {}, key);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

std::uint64_t shifted_word(const std::array<const BlockBits*, 8>& group, int step, int x) {
  const int past = x + (step & 1);
  const int block_x = past >> 3;
  const int word = past & 7;
  // Within a word y is the byte and z the bit in it.
  const auto along_y = [&](int block_z) {
    const std::uint64_t own = (*group[block_x | block_z << 2])[word];
    return (step & 2) == 0 ? own : own >> 8 | (*group[block_x | 2 | block_z << 2])[word] << 56;
  };
  if ((step & 4) == 0) return along_y(0);
  constexpr std::uint64_t kLowBits = 0x0101010101010101ULL;
  return (along_y(0) >> 1 & ~(kLowBits << 7)) | (along_y(1) & kLowBits) << 7;
}

}  // namespace isoextract

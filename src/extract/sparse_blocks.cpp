#include "extract/sparse_blocks.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/parallel.hpp"

namespace isoextract::extract {
namespace {

// Appends the places whose 2x2x2 group of places lies partly in the tile and partly outside it.
void add_tile_skin(const field::SparseTile& tile, std::vector<glm::ivec3>& places) {
  const int blocks = tile.size / kBlockSize;
  const auto on_skin = [&](int b) { return b == -1 || b == blocks - 1; };
  for (int x = -1; x < blocks; ++x) {
    for (int y = -1; y < blocks; ++y) {
      const int step = on_skin(x) || on_skin(y) ? 1 : blocks;  // inside the x and y range, only the two ends along z
      for (int z = -1; z < blocks; z += step) places.push_back(tile.origin + kBlockSize * glm::ivec3(x, y, z));
    }
  }
}

}  // namespace

field::IndexBox stored_box(const field::SparseSamples& samples) {
  field::IndexBox box{glm::ivec3(std::numeric_limits<int>::max()), glm::ivec3(std::numeric_limits<int>::min())};
  const auto add = [&](const glm::ivec3& origin, int size) {
    box.min = glm::min(box.min, origin);
    box.max = glm::max(box.max, origin + (size - 1));
  };
  for (const field::SparseBlock& block : samples.blocks) add(block.origin, kBlockSize);
  for (const field::SparseTile& tile : samples.tiles) add(tile.origin, tile.size);
  return box;
}

std::uint64_t tile_skin_bytes(const field::SparseSamples& samples, const InsideRule& rule,
                              const field::ValueScale& scale) {
  constexpr std::uint64_t kBytesAPlace = 128;
  const bool background_inside = rule(scale(samples.background));
  std::uint64_t places = 0;
  for (const field::SparseTile& tile : samples.tiles) {
    if (tile.size < field::SparseLookup::Node::kSize || rule(scale(tile.value)) == background_inside) continue;
    const auto blocks = static_cast<std::uint64_t>(tile.size / kBlockSize);
    places += (blocks + 1) * (blocks + 1) * (blocks + 1) - (blocks - 1) * (blocks - 1) * (blocks - 1);
  }
  return places * kBytesAPlace;
}

std::uint64_t unstored_places_bytes(const field::SparseSamples& samples, std::size_t nodes) {
  constexpr std::uint64_t kBytesAPlace = 3 * sizeof(glm::ivec3);  // in a growing list, then in the joined list
  constexpr std::uint64_t kBefore = 7;  // places before a stored one that share a cell with it
  constexpr std::uint64_t kOwn = 1;     // a tile of one place is itself a place without a block
  constexpr std::uint64_t kNodePlaces = (field::SparseLookup::Node::kPlaces + 1) *
                                        (field::SparseLookup::Node::kPlaces + 1) *
                                        (field::SparseLookup::Node::kPlaces + 1);
  std::uint64_t places = kBefore * samples.blocks.size();
  for (const field::SparseTile& tile : samples.tiles) {
    const auto side = static_cast<std::uint64_t>(tile.size / kBlockSize);
    if (tile.size < field::SparseLookup::Node::kSize)
      places += side == 1 ? kBefore + kOwn : kBefore * side * side * side;
  }
  return std::min(places, kNodePlaces * nodes) * kBytesAPlace;
}

std::vector<glm::ivec3> find_unstored_places(const field::SparseSamples& samples, const field::SparseLookup& lookup,
                                             const ConstantSides& sides) {
  enum class State : std::uint8_t { outside, inside, block };
  const auto state = [&](std::int32_t place) {
    if (place >= 0) return State::block;
    return sides.inside(place) ? State::inside : State::outside;
  };
  const State background = state(field::SparseLookup::kBackground);

  // Every node checks its own places and the places just before the node.
  constexpr int kPlaces = field::SparseLookup::Node::kPlaces;
  constexpr int kSide = kPlaces + 2;
  std::vector<std::vector<glm::ivec3>> found(lookup.nodes().size() + 1);
  for_each_index(lookup.nodes().size(), [&](std::size_t n) {
    const field::SparseLookup::Node& node = lookup.nodes()[n];
    // Checks only each stored place and the places before it, instead of the whole node, if few places are stored.
    constexpr std::size_t kLittle = 64;
    std::vector<std::int32_t> stored;  // slots
    for (std::size_t slot = 0; slot < node.contents.size() && stored.size() <= kLittle; ++slot) {
      if (state(node.contents[slot]) != background) stored.push_back(static_cast<std::int32_t>(slot));
    }
    if (stored.size() <= kLittle) {
      for (const std::int32_t slot : stored) {
        const glm::ivec3 place = node.origin + kBlockSize * glm::ivec3(slot >> 8, slot >> 4 & 15, slot & 15);
        for (int c = 0; c < 8; ++c) {
          const glm::ivec3 before = place - kBlockSize * glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
          const field::SparseLookup::Group group = lookup.group(before);
          if (group[0] >= 0) continue;
          const State here = state(group[0]);
          if (std::ranges::any_of(group, [&](std::int32_t p) { return state(p) != here; })) found[n].push_back(before);
        }
      }
      return;
    }
    const auto origin_at = [&](int x, int y, int z) { return node.origin + kBlockSize * (glm::ivec3(x, y, z) - 1); };
    const auto at = [](int x, int y, int z) {
      const int slot = (x * kSide + y) * kSide + z;
      return static_cast<std::size_t>(slot);
    };
    const auto within = [](int i) { return i >= 1 && i <= kPlaces; };
    std::array<State, kSide * kSide * kSide> states;
    for (int x = 0; x < kSide; ++x) {
      for (int y = 0; y < kSide; ++y) {
        for (int z = 0; z < kSide; ++z) {
          const glm::ivec3 place = origin_at(x, y, z);
          const bool own = within(x) && within(y) && within(z);
          states[at(x, y, z)] =
              state(own ? node.contents[field::SparseLookup::Node::slot(place)] : lookup.place(place));
        }
      }
    }
    for (int x = 0; x <= kPlaces; ++x) {
      for (int y = 0; y <= kPlaces; ++y) {
        for (int z = 0; z <= kPlaces; ++z) {
          const State here = states[at(x, y, z)];
          if (here == State::block) continue;
          bool alike = true;
          for (int c = 1; c < 8; ++c) alike &= states[at(x + (c & 1), y + (c >> 1 & 1), z + (c >> 2))] == here;
          if (alike) continue;
          found[n].push_back(origin_at(x, y, z));
        }
      }
    }
  });
  // There may be no node between large tiles and the background.
  std::vector<glm::ivec3>& skins = found.back();
  for (std::size_t t = 0; t < samples.tiles.size(); ++t) {
    if (samples.tiles[t].size >= field::SparseLookup::Node::kSize &&
        state(field::SparseLookup::place_of_tile(t)) != background) {
      add_tile_skin(samples.tiles[t], skins);
    }
  }
  std::erase_if(skins, [&](const glm::ivec3& p) { return lookup.block(p) >= 0; });

  std::vector<glm::ivec3> places;
  places.reserve(std::accumulate(found.begin(), found.end(), std::size_t{0},
                                 [](std::size_t sum, const auto& part) { return sum + part.size(); }));
  for (const auto& part : found) places.insert(places.end(), part.begin(), part.end());
  std::ranges::sort(places, {}, [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); });
  places.erase(std::unique(places.begin(), places.end()), places.end());
  return places;
}

SitePlanes site_planes(const std::array<const BlockBits*, 8>& group) {
  // Byte y of a word holds row y; its bit z is sample z.
  constexpr std::uint64_t kLowBits = 0x0101010101010101ULL;
  SitePlanes planes;
  for (std::size_t x = 0; x < planes.size(); ++x) {
    const std::size_t past = x >> 3;  // the block after this one along x
    const std::size_t word = x & 7;
    const std::uint64_t own = (*group[past])[word];
    const std::uint64_t y = (*group[past | 2])[word];
    const std::uint64_t z = (*group[past | 4])[word];
    const std::uint64_t yz = (*group[past | 6])[word];
    const std::uint64_t own_y = own >> 8 | y << 56;
    const std::uint64_t z_y = z >> 8 | yz << 56;
    const auto along_z = [](std::uint64_t here, std::uint64_t next) {
      return (here >> 1 & ~(kLowBits << 7)) | (next & kLowBits) << 7;
    };
    planes[x] = {own, own_y, along_z(own, z), along_z(own_y, z_y)};
  }
  return planes;
}

}  // namespace isoextract::extract

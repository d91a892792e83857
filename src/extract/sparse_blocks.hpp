// Finds the places of a sparse grid that have no stored block but may own a part of the surface. A place is a box of
// 8x8x8 samples whose origin is a multiple of 8 along each axis. A place has the values of a stored block, a tile or
// the background. A place owns the cells whose lowest sample it contains. BlockBits has one bit for each of the 512
// samples of a place: 1 if the sample is inside.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "extract/inside_test.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::extract {

inline constexpr int kBlockSize = field::SparseBlock::kSize;

// Returns the box of all stored blocks and tiles; an empty box if there are none.
[[nodiscard]] field::IndexBox stored_box(const field::SparseSamples& samples);

// A place and its 26 neighbors get slots 0 to 26, x fastest; each component of `away` is -1, 0 or 1.
inline constexpr std::size_t kNearPlaces = 27;
[[nodiscard]] inline std::size_t near_place_slot(const glm::ivec3& away) {
  const int slot = (away.x + 1) + 3 * (away.y + 1) + 9 * (away.z + 1);
  return static_cast<std::size_t>(slot);
}

// Calls f(slot, place) for the place at `origin` and its neighbors from `lowest` (0 or -1) to 1 along each axis;
// `place` is the lowest sample of each.
template <class F>
void for_each_near_place(const glm::ivec3& origin, int lowest, const F& f) {
  for (int z = lowest; z <= 1; ++z) {
    for (int y = lowest; y <= 1; ++y) {
      for (int x = lowest; x <= 1; ++x) {
        f(near_place_slot({x, y, z}), origin + field::SparseBlock::kSize * glm::ivec3(x, y, z));
      }
    }
  }
}

// 512 bits in the order of the values of a block: bit 8 * y + z of word x.
using BlockBits = std::array<std::uint64_t, 8>;

// Returns an estimate of the bytes that the list of tile skins takes, without the memory for the mesh at the skins.
// Tiles have a skin if they are at least as large as a node (SparseLookup::Node::kSize), and not on the background's
// side of iso. The skin of a tile consists of the places whose cells cross the tile's faces: those just before its
// lower faces and those inside the tile at its upper faces.
[[nodiscard]] std::uint64_t tile_skin_bytes(const field::SparseSamples& samples, const InsideRule& rule,
                                            const field::ValueScale& scale);

// The side of iso on which the tiles and the background are.
struct ConstantSides {
  std::vector<std::uint8_t> tiles_inside;  // one entry a tile: 1 if it is inside, else 0
  bool background_inside = false;

  // Returns whether a place without a stored block is inside; `place` is the result of SparseLookup::place()
  // (kBackground or a tile).
  [[nodiscard]] bool inside(std::int32_t place) const {
    return place == field::SparseLookup::kBackground ? background_inside
                                                     : tiles_inside[field::SparseLookup::tile_of(place)] != 0;
  }
};

// Returns the most bytes that find_unstored_places() needs for places next to blocks, and next to tiles that are
// smaller than a node. The skins of larger tiles are not included. `nodes` is the number of nodes of the SparseLookup.
[[nodiscard]] std::uint64_t unstored_places_bytes(const field::SparseSamples& samples, std::size_t nodes);

// Returns, sorted by x, y, z, the places without a stored block whose cells may have corners on both sides. The cells
// of such a place reach into a stored block, or into a tile or background of the other side. The list also has the
// skins of tiles (tile_skin_bytes()). Some of these places may have corners on one side only.
[[nodiscard]] std::vector<glm::ivec3> find_unstored_places(const field::SparseSamples& samples,
                                                           const field::SparseLookup& lookup,
                                                           const ConstantSides& sides);

// The inside bits of planes x = 0 to 8 of a block, each four times: unmoved, and moved by one sample along y, along z,
// along both. `group[n]` holds the bits of the block that is n & 1, n >> 1 & 1, n >> 2 & 1 blocks away along x, y, z.
using SitePlanes = std::array<std::array<std::uint64_t, 4>, 9>;
[[nodiscard]] SitePlanes site_planes(const std::array<const BlockBits*, 8>& group);

// Returns the bits of samples p + step for all samples p of plane x; `step` is a sum of 1 (x), 2 (y) and 4 (z).
[[nodiscard]] inline std::uint64_t moved_bits(const SitePlanes& planes, int step, int x) {
  const int plane = x + (step & 1);
  return planes[static_cast<std::size_t>(plane)][static_cast<std::size_t>(step >> 1)];
}

}  // namespace isoextract::extract

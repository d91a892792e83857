// The places of a sparse grid that a surface may pass, and the 512 inside bits of its blocks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "extract/inside_test.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::extract {

inline constexpr int kBlockSize = field::SparseBlock::kSize;

// The box of all blocks and tiles; empty if there are none.
[[nodiscard]] field::IndexBox stored_box(const field::SparseSamples& samples);

// The 3 x 3 x 3 places around and at one, numbered x fastest; `away` is -1 to 1 along each axis.
inline constexpr std::size_t kNearPlaces = 27;
[[nodiscard]] inline std::size_t near_place_slot(const glm::ivec3& away) {
  const int slot = (away.x + 1) + 3 * (away.y + 1) + 9 * (away.z + 1);
  return static_cast<std::size_t>(slot);
}

// f(slot, place) for those of them from `lowest` (0 or -1) to 1 along each axis; `place` is its lowest sample.
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

// 512 bits, in the order of a block's values.
using BlockBits = std::array<std::uint64_t, 8>;

// What listing the skins of large tiles that are not on the background's side will need in memory, about. The mesh on
// them is counted exactly later.
[[nodiscard]] std::uint64_t tile_skin_bytes(const field::SparseSamples& samples, const InsideRule& rule,
                                            const field::ValueScale& scale);

// On which side of iso the constants are.
struct ConstantSides {
  std::vector<std::uint8_t> tiles_inside;  // by tile
  bool background_inside = false;

  // Of a place without a block, as SparseLookup tells it.
  [[nodiscard]] bool inside(std::int32_t place) const {
    return place == field::SparseLookup::kBackground ? background_inside
                                                     : tiles_inside[field::SparseLookup::tile_of(place)] != 0;
  }
};

// What unstored_places() needs at most for places beside blocks and small tiles, those on skins apart.
[[nodiscard]] std::uint64_t unstored_places_bytes(const field::SparseSamples& samples, std::size_t nodes);

// Places without a stored block around which both sides may occur: those that share a cell with a stored block, and the
// skins of tiles that are not on the background's side. Sorted; a place may be named that turns out to be one-sided.
[[nodiscard]] std::vector<glm::ivec3> unstored_places(const field::SparseSamples& samples,
                                                      const field::SparseLookup& lookup, const ConstantSides& sides);

// The bits of the planes x = 0 to 8 of a block, each four times: as they are, and moved by one sample along y, along z,
// along both. `group[n]` are the bits of the block that lies n & 1, n >> 1 & 1, n >> 2 & 1 blocks along x, y, z.
using SitePlanes = std::array<std::array<std::uint64_t, 4>, 9>;
[[nodiscard]] SitePlanes site_planes(const std::array<const BlockBits*, 8>& group);

// The bits of samples p + step for the samples p of plane x; `step` is a set of axis bits.
[[nodiscard]] inline std::uint64_t moved_bits(const SitePlanes& planes, int step, int x) {
  const int plane = x + (step & 1);
  return planes[static_cast<std::size_t>(plane)][static_cast<std::size_t>(step >> 1)];
}

}  // namespace isoextract::extract

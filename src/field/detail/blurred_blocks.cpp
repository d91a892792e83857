#include "field/detail/blurred_blocks.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <utility>

namespace isoextract::field {
namespace {

using Places = std::vector<glm::ivec3>;

constexpr int kPlace = SparseBlock::kSize;

void sort_places(Places& places) {
  std::ranges::sort(places, {}, [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); });
  places.erase(std::unique(places.begin(), places.end()), places.end());
}

// Returns `places` and all places at most `rings` places away. Extends the list axis by axis.
Places grown(Places places, int rings) {
  for (int axis = 0; axis < 3; ++axis) {
    Places more;
    more.reserve(places.size() * static_cast<std::size_t>(2 * rings + 1));
    for (const glm::ivec3& place : places) {
      for (int ring = -rings; ring <= rings; ++ring) {
        more.push_back(place);
        more.back()[axis] += ring * kPlace;
      }
    }
    sort_places(more);
    places = std::move(more);
  }
  return places;
}

// Calls f(place) for the places within `rings` of a tile's boundary, on both sides of it.
template <class F>
void for_each_boundary_place(const SparseTile& tile, int rings, const F& f) {
  const int side = tile.size / kPlace;
  for (int x = -rings; x < side + rings; ++x) {
    for (int y = -rings; y < side + rings; ++y) {
      const bool at_side = std::min({x, y, side - 1 - x, side - 1 - y}) < rings;
      for (int z = -rings; z < side + rings; ++z) {
        if (!at_side && z == rings && side > 2 * rings) z = side - rings;
        f(tile.origin + kPlace * glm::ivec3(x, y, z));
      }
    }
  }
}

std::uint64_t count_boundary_places(const SparseTile& tile, int rings) {
  const auto cube = [](std::int64_t side) { return static_cast<std::uint64_t>(side * side * side); };
  const std::int64_t side = tile.size / kPlace;
  return cube(side + 2 * rings) - cube(std::max<std::int64_t>(0, side - 2 * rings));
}

bool has_one_value_around(const SparseLookup& lookup, const glm::ivec3& place, int rings) {
  const double value = lookup.constant(place);
  for (int x = -rings; x <= rings; ++x) {
    for (int y = -rings; y <= rings; ++y) {
      for (int z = -rings; z <= rings; ++z) {
        if (lookup.constant(place + kPlace * glm::ivec3(x, y, z)) != value) return false;
      }
    }
  }
  return true;
}

// Adds the remainder of a tile around the places that become blocks, as cubes of the largest possible size.
void add_tile_remainder(const SparseTile& tile, const Places& blocks, std::vector<SparseTile>& tiles) {
  if (blocks.empty()) {
    tiles.push_back(tile);
    return;
  }
  if (tile.size == kPlace) return;
  const int half = tile.size / 2;
  std::array<Places, 8> parts;
  for (const glm::ivec3& block : blocks) {
    const glm::ivec3 at = (block - tile.origin) / half;
    parts[static_cast<std::size_t>(at.x << 2 | at.y << 1 | at.z)].push_back(block);
  }
  for (int part = 0; part < 8; ++part) {
    const glm::ivec3 origin = tile.origin + half * glm::ivec3(part >> 2, part >> 1 & 1, part & 1);
    add_tile_remainder({origin, half, tile.value}, parts[static_cast<std::size_t>(part)], tiles);
  }
}

}  // namespace

Result<BlurredBlocks> find_blurred_blocks(const SparseSamples& samples, const SparseLookup& lookup, int reach,
                                          const std::string& what, const Context& context) {
  const int rings = (reach + kPlace - 1) / kPlace;
  const auto width = 2 * static_cast<std::uint64_t>(rings) + 1;
  std::uint64_t at_boundaries = 0;
  for (const SparseTile& tile : samples.tiles) at_boundaries += count_boundary_places(tile, rings);
  // The rings around connected blocks mostly overlap.
  auto memory =
      TRY(context.reserve((samples.blocks.size() * width * width * 2 + at_boundaries * 4) * sizeof(glm::ivec3), what));
  Places places;
  for (const SparseBlock& block : samples.blocks) places.push_back(block.origin);
  places = grown(std::move(places), rings);
  const std::size_t around_blocks = places.size();
  for (const SparseTile& tile : samples.tiles) {
    for_each_boundary_place(tile, rings, [&](const glm::ivec3& place) {
      const auto key = [](const glm::ivec3& p) { return std::tuple(p.x, p.y, p.z); };
      const auto end = places.begin() + static_cast<std::ptrdiff_t>(around_blocks);
      const auto found = std::ranges::lower_bound(places.begin(), end, key(place), {}, key);
      const bool known = found != end && *found == place;
      if (!known && !has_one_value_around(lookup, place, rings)) places.push_back(place);
    });
  }
  sort_places(places);

  BlurredBlocks result;
  std::vector<Places> of_tile(samples.tiles.size());
  for (const glm::ivec3& place : places) {
    const std::int32_t stored = lookup.place(place);
    if (stored < SparseLookup::kBackground) of_tile[SparseLookup::tile_of(stored)].push_back(place);
  }
  for (std::size_t t = 0; t < samples.tiles.size(); ++t) add_tile_remainder(samples.tiles[t], of_tile[t], result.tiles);
  result.origins = std::move(places);
  result.memory = std::move(memory);
  return result;
}

}  // namespace isoextract::field

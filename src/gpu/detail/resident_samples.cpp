#include "gpu/detail/resident_samples.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

// Compiles the hash into this file, so that the program does not need the library at run time.
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "gpu/detail/field_source.hpp"

namespace isoextract::gpu {
namespace {

std::uint64_t count_of(const glm::ivec3& places) {
  const glm::u64vec3 wide(places);
  return wide.x * wide.y * wide.z;
}

constexpr std::uint64_t kSamplesOfBrick = std::uint64_t{kBrickSamples} * kBrickSamples * kBrickSamples;

}  // namespace

BrickHash brick_hash(const field::DenseSamples& samples, const field::IndexBox& part) {
  const std::array<std::int32_t, 6> place{part.min.x, part.min.y, part.min.z, part.max.x, part.max.y, part.max.z};
  // Hashes one contiguous copy: hashing many short rows would cost more than copying them.
  alignas(64) std::array<std::byte, sizeof(place) + kSamplesOfBrick * sizeof(double)> piece;
  std::memcpy(piece.data(), place.data(), sizeof(place));
  std::size_t end = sizeof(place);
  const std::size_t size = field::sample_size(samples.type);
  const std::size_t row = size * static_cast<std::size_t>(part.max.x - part.min.x + 1);
  const glm::u64vec3 dims(samples.dims);
  const auto* data = static_cast<const std::byte*>(samples.data);
  for (int z = part.min.z; z <= part.max.z; ++z) {
    for (int y = part.min.y; y <= part.max.y; ++y) {
      const glm::u64vec3 at(part.min.x, y, z);
      std::memcpy(piece.data() + end, data + size * (at.x + dims.x * (at.y + dims.y * at.z)), row);
      end += row;
    }
  }
  const XXH128_hash_t hash = XXH3_128bits(piece.data(), end);
  return {hash.low64, hash.high64};
}

Result<bool> ResidentSamples::make_room(const gl::GlContext& context, const BrickLattice& lattice,
                                        const field::IndexBox& bricks, const TextureLimits& limits,
                                        const Context& host) {
  const glm::ivec3 wanted(bricks.dims());
  const bool is_same = lattice == lattice_;
  if (is_same && glm::all(glm::lessThanEqual(wanted, bricks_per_axis_))) return true;
  const auto fits = [&](const glm::ivec3& places) {
    const glm::i64vec3 size = std::int64_t{kBrickSamples} * glm::i64vec3(places);
    return std::max({size.x, size.y, size.z}) <= limits.size &&
           count_of(places) * kSamplesOfBrick * field::sample_size(lattice.type) <= limits.bytes;
  };
  // Growing to the maximum of both sizes makes reallocations rare for fields that move.
  const glm::ivec3 either = is_same ? glm::max(wanted, bricks_per_axis_) : wanted;
  const glm::ivec3 places = fits(either) ? either : wanted;
  drop();
  if (!fits(places)) return false;
  auto memory = host.reserve(count_of(places) * sizeof(BrickHash), "the bricks on the device");
  if (!memory) return false;  // extraction works without resident samples
  auto texture = TRY(make_sample_texture(context, lattice.type, kBrickSamples * places));
  lattice_ = lattice;
  bricks_per_axis_ = places;
  texture_ = std::move(texture);
  memory_ = std::move(*memory);
  return true;
}

void ResidentSamples::drop() { *this = ResidentSamples(); }

std::size_t ResidentSamples::hash_index(const glm::ivec3& brick) const {
  const glm::u64vec3 at(brick % bricks_per_axis_);
  const glm::u64vec3 size(bricks_per_axis_);
  return at.x + size.x * (at.y + size.y * at.z);
}

std::vector<BrickHash> ResidentSamples::take_hashes() {
  std::vector<BrickHash> hashes = std::exchange(hashes_, {});
  hashes.resize(count_of(bricks_per_axis_));
  return hashes;
}

}  // namespace isoextract::gpu

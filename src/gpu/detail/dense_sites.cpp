#include "gpu/detail/dense_sites.hpp"

#include <algorithm>

#include "base/parallel.hpp"
#include "extract/edge_geometry.hpp"
#include "extract/row_bits.hpp"

namespace isoextract::gpu {
namespace {

std::size_t brick_index(const glm::ivec3& bricks, const glm::ivec3& b) {
  return static_cast<std::size_t>(b.x) +
         static_cast<std::size_t>(bricks.x) *
             (static_cast<std::size_t>(b.y) + static_cast<std::size_t>(bricks.y) * static_cast<std::size_t>(b.z));
}

// Checks the eight bricks of word `w` in brick row (bj, bk): bit b is set if brick b has samples on both sides. The
// samples of a brick include the samples that its last cells share with the next bricks.
unsigned mixed_bricks(const extract::DenseMasks& masks, int w, int bj, int bk) {
  const glm::ivec3 dims = masks.dims();
  const std::uint64_t own = extract::bits_below(w, dims.x);
  const std::uint64_t shared = extract::bits_below(w, dims.x - 1);
  std::uint64_t any = 0;
  std::uint64_t all = ~std::uint64_t{0};
  for (int k = kBrickCells * bk; k < std::min(kBrickCells * (bk + 1) + 1, dims.z); ++k) {
    for (int j = kBrickCells * bj; j < std::min(kBrickCells * (bj + 1) + 1, dims.y); ++j) {
      const std::uint64_t* row = masks.row(j, k);
      const std::uint64_t next = row[w] >> 1 | row[w + 1] << 63;
      any |= (row[w] & own) | (next & shared);
      all &= (row[w] | ~own) & (next | ~shared);
    }
  }
  unsigned mixed = 0;
  for (int b = 0; b < 8; ++b) {
    const bool some = (any >> (8 * b) & 0xFF) != 0;
    const bool every = (all >> (8 * b) & 0xFF) == 0xFF;
    mixed |= (some && !every ? 1U : 0U) << b;
  }
  return mixed;
}

}  // namespace

DenseSites::DenseSites(const extract::DenseMasks& masks, const glm::ivec3& low)
    : low_(low),
      bricks_((masks.dims() + kBrickCells - 1) / kBrickCells),
      numbers_(brick_index(bricks_, {0, 0, bricks_.z}), -1) {
  for_each_index(bricks_.z, [&](int bk) {
    for (int bj = 0; bj < bricks_.y; ++bj) {
      for (int w = 0; w < masks.words(); ++w) {
        const unsigned mixed = mixed_bricks(masks, w, bj, bk);
        for (int b = 0; b < 8; ++b) {
          if ((mixed >> b & 1) != 0) numbers_[brick_index(bricks_, {8 * w + b, bj, bk})] = 0;
        }
      }
    }
  });
  glm::ivec3 b(0);
  for (; b.z < bricks_.z; ++b.z) {
    for (b.y = 0; b.y < bricks_.y; ++b.y) {
      for (b.x = 0; b.x < bricks_.x; ++b.x) {
        std::int32_t& number = numbers_[brick_index(bricks_, b)];
        if (number < 0) continue;
        number = static_cast<std::int32_t>(origins_.size());
        origins_.push_back(low_ + kBrickCells * b);
      }
    }
  }
}

std::int32_t DenseSites::site(const glm::ivec3& p) const {
  const glm::ivec3 brick = (p - low_) / kBrickCells;
  return glm::all(glm::lessThan(brick, bricks_)) ? numbers_[brick_index(bricks_, brick)] : -1;
}

std::array<std::int32_t, 8> DenseSites::near(std::size_t site_number) const {
  std::array<std::int32_t, 8> sites;
  for (int n = 0; n < 8; ++n) sites[n] = site(origins_[site_number] + kBrickCells * extract::direction_step(n));
  return sites;
}

}  // namespace isoextract::gpu

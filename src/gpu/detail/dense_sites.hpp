// Finds the bricks of dense samples that a surface may pass.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "extract/dense_masks.hpp"
#include "field/samples.hpp"

namespace isoextract::gpu {

constexpr int kBrickCells = 8;  // along each axis

// A site is a brick of 8x8x8 cells with samples inside and outside the surface. It owns the edges whose lower end is
// one of its 8x8x8 lowest samples.
class DenseSites {
 public:
  // `masks` are the inside bits of the samples from `low` on.
  DenseSites(const extract::DenseMasks& masks, const glm::ivec3& low);

  // Returns the most bytes that an object needs for masks of these dims.
  [[nodiscard]] static std::uint64_t bytes(const glm::ivec3& dims) {
    const glm::u64vec3 bricks = (glm::u64vec3(dims) + std::uint64_t{kBrickCells - 1}) / std::uint64_t{kBrickCells};
    return bricks.x * bricks.y * bricks.z * (sizeof(std::int32_t) + sizeof(glm::ivec3));
  }
  // Returns the lowest sample of each site, in field indices; sorted by z, then y, then x.
  [[nodiscard]] const std::vector<glm::ivec3>& origins() const { return origins_; }
  [[nodiscard]] std::uint64_t bricks() const { return numbers_.size(); }  // all bricks, sites or not

  // Returns the site that owns sample `p`, or -1. `p` must not be below `low`.
  [[nodiscard]] std::int32_t site(const glm::ivec3& p) const;
  // Returns the sites at +0 or +1 along x (bit 0 of the index), y (bit 1) and z (bit 2) from `site`; -1 if there is no
  // such site. They own the edges of the cells of `site`.
  [[nodiscard]] std::array<std::int32_t, 8> near(std::size_t site) const;

 private:
  glm::ivec3 low_;
  glm::ivec3 bricks_;
  std::vector<std::int32_t> numbers_;  // by brick; -1 if it is not a site
  std::vector<glm::ivec3> origins_;
};

}  // namespace isoextract::gpu

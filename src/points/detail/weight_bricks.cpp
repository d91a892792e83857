#include "points/detail/weight_bricks.hpp"

#include <array>

#include "field/samples.hpp"

namespace isoextract::points {
namespace {

constexpr int kWeightSide = field::SparseBlock::kSize;

}  // namespace

template <class F>
void WeightBricks::for_each_share(const glm::ivec3& origin, const F& f) const {
  const glm::dvec3 low(origin);
  const auto add = [&](std::size_t spot, const glm::ivec3& sample, double share) {
    const glm::ivec3 p = sample - origin;
    if (glm::any(glm::lessThan(p, glm::ivec3(0))) || glm::any(glm::greaterThanEqual(p, glm::ivec3(kWeightSide))))
      return;
    if (share != 0) f(spot, static_cast<std::size_t>(p.x << 6 | p.y << 3 | p.z), share);
  };
  grid_.for_each_spot_run(low - 1.0, low + static_cast<double>(kWeightSide), [&](std::size_t first, std::size_t last) {
    for (std::size_t s = first; s != last; ++s) {
      const glm::dvec3& p = grid_.position(s);
      if (deposit_ == Deposit::nearest) {
        add(s, glm::ivec3(glm::floor(p + 0.5)), 1);
        continue;
      }
      const glm::dvec3 floor = glm::floor(p);
      const glm::dvec3 above = p - floor;
      for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 up(corner & 1, corner >> 1 & 1, corner >> 2);
        double share = 1;
        for (int axis = 0; axis < 3; ++axis) share *= up[axis] != 0 ? above[axis] : 1 - above[axis];
        add(s, glm::ivec3(floor) + up, share);
      }
    }
  });
}

bool WeightBricks::touches(const glm::ivec3& origin) const {
  bool found = false;
  for_each_share(origin, [&](std::size_t, std::size_t, double) { found = true; });
  return found;
}

void WeightBricks::fill(const glm::ivec3& origin, float* values, const ContributingSpots& marks) const {
  std::array<double, kWeightSide * kWeightSide * kWeightSide> sums{};
  for_each_share(origin, [&](std::size_t spot, std::size_t slot, double share) {
    sums[slot] += share * static_cast<double>(grid_.members(spot).size());
    marks.mark(spot);
  });
  for (std::size_t v = 0; v < sums.size(); ++v) values[v] = static_cast<float>(weight_ * sums[v]);
}

}  // namespace isoextract::points

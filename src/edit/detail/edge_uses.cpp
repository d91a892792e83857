#include "edit/detail/edge_uses.hpp"

#include <algorithm>
#include <tuple>

#include <tbb/parallel_sort.h>

#include "mesh/adjacency.hpp"

namespace isoextract::edit {

EdgeUses::EdgeUses(std::span<const glm::uvec3> triangles) {
  uses_.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (mesh::has_repeated_index(triangles[t])) continue;
    for (std::uint8_t side = 0; side < 3; ++side) {
      const std::uint32_t from = triangles[t][side];
      const std::uint32_t to = triangles[t][(side + 1) % 3];
      uses_.push_back({std::min(from, to), std::max(from, to), t, side, from < to});
    }
  }
  tbb::parallel_sort(uses_.begin(), uses_.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
}

std::span<const EdgeUse> EdgeUses::of_edge(std::uint32_t a, std::uint32_t b) const {
  struct Edge {
    std::uint32_t low, high;
  };
  const Edge edge{std::min(a, b), std::max(a, b)};
  const auto less = [](const auto& x, const auto& y) { return std::tie(x.low, x.high) < std::tie(y.low, y.high); };
  const auto first = std::lower_bound(uses_.begin(), uses_.end(), edge, less);
  const auto last = std::upper_bound(first, uses_.end(), edge, less);
  return {first, last};
}

}  // namespace isoextract::edit

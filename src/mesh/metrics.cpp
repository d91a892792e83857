#include "mesh/metrics.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"
#include "mesh/detail/triangle_sums.hpp"

namespace isoextract::mesh {
namespace {

constexpr std::size_t kPositionsAtATime = 1 << 15;

}  // namespace

LocalBounds measure_local_bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  return reduce_ranges(
             mesh.positions.size(), kPositionsAtATime, GrowingBounds(),
             [&](std::size_t begin, std::size_t end, GrowingBounds bounds) {
               bounds.add(mesh.positions.span().subspan(begin, end - begin));
               return bounds;
             },
             [](GrowingBounds a, const GrowingBounds& b) {
               a.add(b);
               return a;
             })
      .get();
}

Bounds measure_bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  const LocalBounds local = measure_local_bounds(mesh);
  return {mesh.origin + glm::dvec3(local.min), mesh.origin + glm::dvec3(local.max)};
}

float farthest_coordinate(std::span<const glm::vec3> positions) {
  return reduce_ranges(
      positions.size(), kPositionsAtATime, 0.0F,
      [&](std::size_t begin, std::size_t end, float farthest) {
        for (std::size_t v = begin; v != end; ++v) {
          const glm::vec3 size = glm::abs(positions[v]);
          farthest = std::max({farthest, size.x, size.y, size.z});
        }
        return farthest;
      },
      [](float a, float b) { return std::max(a, b); });
}

MeshSize measure_size(const Mesh& mesh) {
  if (mesh.triangles.empty()) return {};
  const glm::dvec3 apex(mesh.positions[0]);
  return reduce_ranges(
      mesh.triangles.size(), kSizeGrain, MeshSize{},
      [&](std::size_t begin, std::size_t end, const MeshSize& sum) {
        return with_sizes(sum, mesh.positions.span(), mesh.triangles.span().subspan(begin, end - begin), apex);
      },
      joined);
}

double typical_edge(const Mesh& mesh) {
  if (mesh.triangles.empty()) return 1;
  const double edge = std::sqrt(2 * measure_size(mesh).area / static_cast<double>(mesh.triangles.size()));
  return std::isfinite(edge) && edge > 0 ? edge : 1;
}

}  // namespace isoextract::mesh

#include "mesh/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.hpp"

namespace isoextract::mesh {
namespace {

// Chunks of fixed size, so that sums do not depend on the number of threads.
constexpr std::size_t kTrianglesAtATime = 1 << 15;

}  // namespace

LocalBounds measure_local_bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  return reduce_ranges(
             mesh.positions.size(), kTrianglesAtATime, GrowingBounds(),
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
      positions.size(), kTrianglesAtATime, 0.0F,
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
  // The volume is a sum of tetrahedra with a vertex of the mesh as apex: it is never far away, so little cancels.
  const glm::dvec3 apex(mesh.positions[0]);
  return reduce_ranges(
      mesh.triangles.size(), kTrianglesAtATime, MeshSize{},
      [&](std::size_t begin, std::size_t end, MeshSize sum) {
        for (std::size_t t = begin; t != end; ++t) {
          const glm::uvec3 triangle = mesh.triangles[t];
          const glm::dvec3 a(mesh.positions[triangle.x]);
          const glm::dvec3 b(mesh.positions[triangle.y]);
          const glm::dvec3 c(mesh.positions[triangle.z]);
          const glm::dvec3 normal = glm::cross(b - a, c - a);
          const double length = glm::length(normal);
          sum.area += length / 2;
          sum.volume += glm::dot(a - apex, normal) / 6;
          sum.zero_area_triangles += length == 0 ? 1 : 0;
        }
        return sum;
      },
      [](const MeshSize& a, const MeshSize& b) {
        return MeshSize{a.area + b.area, a.volume + b.volume, a.zero_area_triangles + b.zero_area_triangles};
      });
}

double typical_edge(const Mesh& mesh) {
  if (mesh.triangles.empty()) return 1;
  const double edge = std::sqrt(2 * measure_size(mesh).area / static_cast<double>(mesh.triangles.size()));
  return std::isfinite(edge) && edge > 0 ? edge : 1;
}

}  // namespace isoextract::mesh

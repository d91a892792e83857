#include "mesh/metrics.hpp"

#include <algorithm>
#include <limits>

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

namespace isoextract::mesh {
namespace {

// Fixed-size chunks, summed by a deterministic reduction, so that nothing depends on the number of threads. Least and
// greatest coordinates do not depend on the order anyway.
constexpr std::size_t kTrianglesAtATime = 1 << 15;

using Range = tbb::blocked_range<std::size_t>;

}  // namespace

LocalBounds measure_local_bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  return tbb::parallel_reduce(
      Range(0, mesh.positions.size(), kTrianglesAtATime), LocalBounds{glm::vec3(kInfinity), glm::vec3(-kInfinity)},
      [&](const Range& range, LocalBounds bounds) {
        for (std::size_t v = range.begin(); v != range.end(); ++v) {
          bounds.min = glm::min(bounds.min, mesh.positions[v]);
          bounds.max = glm::max(bounds.max, mesh.positions[v]);
        }
        return bounds;
      },
      [](const LocalBounds& a, const LocalBounds& b) {
        return LocalBounds{glm::min(a.min, b.min), glm::max(a.max, b.max)};
      });
}

Bounds measure_bounds(const Mesh& mesh) {
  if (mesh.positions.empty()) return {};
  const LocalBounds local = measure_local_bounds(mesh);
  return {mesh.origin + glm::dvec3(local.min), mesh.origin + glm::dvec3(local.max)};
}

float farthest_coordinate(std::span<const glm::vec3> positions) {
  return tbb::parallel_reduce(
      Range(0, positions.size(), kTrianglesAtATime), 0.0F,
      [&](const Range& range, float farthest) {
        for (std::size_t v = range.begin(); v != range.end(); ++v) {
          const glm::vec3 size = glm::abs(positions[v]);
          farthest = std::max({farthest, size.x, size.y, size.z});
        }
        return farthest;
      },
      [](float a, float b) { return std::max(a, b); });
}

MeshSize measure_size(const Mesh& mesh) {
  if (mesh.triangles.empty()) return {};
  // Volume as a sum of tetrahedra to one vertex of the mesh: far from it in no direction, so little cancels.
  const glm::dvec3 apex(mesh.positions[0]);
  return tbb::parallel_deterministic_reduce(
      Range(0, mesh.triangles.size(), kTrianglesAtATime), MeshSize{},
      [&](const Range& range, MeshSize sum) {
        for (std::size_t t = range.begin(); t != range.end(); ++t) {
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

}  // namespace isoextract::mesh

// Sums over consecutive triangles. A mesh in memory and a mesh that comes in parts add the same numbers in the same
// order, so their sums are equal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "mesh/adjacency.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::mesh {

// Sums of MeshSize are made by reduce_ranges() with this grain.
inline constexpr std::size_t kSizeGrain = 1 << 15;

// Returns `sum` with the sizes of the triangles added. The volume is a sum of tetrahedra with the top `apex`: the first
// vertex of the mesh, which is never far away, so little cancels.
[[nodiscard]] inline MeshSize with_sizes(MeshSize sum, std::span<const glm::vec3> positions,
                                         std::span<const glm::uvec3> triangles, const glm::dvec3& apex) {
  for (const glm::uvec3& triangle : triangles) {
    const glm::dvec3 a(positions[triangle.x]);
    const glm::dvec3 b(positions[triangle.y]);
    const glm::dvec3 c(positions[triangle.z]);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    sum.area += length / 2;
    sum.volume += glm::dot(a - apex, normal) / 6;
    sum.zero_area_triangles += length == 0 ? 1 : 0;
  }
  return sum;
}

[[nodiscard]] inline MeshSize joined(const MeshSize& a, const MeshSize& b) {
  return {a.area + b.area, a.volume + b.volume, a.zero_area_triangles + b.zero_area_triangles};
}

// Sums of components are made in chunks of this many triangles of the whole mesh. One thread sums a chunk, and the sums
// of the chunks are added in order. Triangles follow the order of the grid, so a chunk has few components.
inline constexpr std::size_t kComponentChunk = 1 << 14;

struct ComponentSum {
  std::uint32_t component = 0;
  std::uint64_t triangles = 0;
  double area = 0;
  double volume = 0;
  glm::vec3 min{std::numeric_limits<float>::infinity()};
  glm::vec3 max{-std::numeric_limits<float>::infinity()};
};

// The space in which components are measured, relative to the first vertex of the mesh.
struct SumSpace {
  glm::dvec3 apex{0.0};
  glm::dmat3 to_metric{1.0};
  double handedness = 1;  // -1 if to_metric mirrors: it must not turn shells inside out
};

// Adds triangles to the sums of a chunk, one for each component in it. component_of(vertex) must be the same for all
// corners of a triangle. Leaves out triangles that repeat an index.
template <class ComponentOf>
void add_triangles(std::vector<ComponentSum>& sums, std::span<const glm::vec3> positions,
                   std::span<const glm::uvec3> triangles, const SumSpace& space, const ComponentOf& component_of) {
  for (const glm::uvec3& t : triangles) {
    if (has_repeated_index(t)) continue;
    const std::uint32_t component = component_of(t.x);
    auto sum = std::find_if(sums.rbegin(), sums.rend(), [&](const auto& s) { return s.component == component; });
    if (sum == sums.rend()) {
      sums.push_back({.component = component});
      sum = sums.rbegin();
    }
    const glm::dvec3 a = space.to_metric * (glm::dvec3(positions[t.x]) - space.apex);
    const glm::dvec3 b = space.to_metric * (glm::dvec3(positions[t.y]) - space.apex);
    const glm::dvec3 c = space.to_metric * (glm::dvec3(positions[t.z]) - space.apex);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    ++sum->triangles;
    sum->area += glm::length(normal) / 2;
    sum->volume += space.handedness * glm::dot(a, normal) / 6;
    for (int corner = 0; corner < 3; ++corner) {
      sum->min = glm::min(sum->min, positions[t[corner]]);
      sum->max = glm::max(sum->max, positions[t[corner]]);
    }
  }
}

// Returns the facts of `count` components before the first chunk is added to them.
[[nodiscard]] inline std::vector<ComponentFacts> facts_without_triangles(std::size_t count) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<ComponentFacts> facts(count);
  for (ComponentFacts& fact : facts) fact.bounds = {glm::dvec3(kInfinity), glm::dvec3(-kInfinity)};
  return facts;
}

// Adds the sums of a chunk of a mesh with this origin.
inline void add_chunk(std::vector<ComponentFacts>& facts, std::span<const ComponentSum> chunk,
                      const glm::dvec3& origin) {
  for (const ComponentSum& sum : chunk) {
    ComponentFacts& fact = facts[sum.component];
    fact.triangles += sum.triangles;
    fact.area += sum.area;
    fact.volume += sum.volume;
    fact.bounds.min = glm::min(fact.bounds.min, origin + glm::dvec3(sum.min));
    fact.bounds.max = glm::max(fact.bounds.max, origin + glm::dvec3(sum.max));
  }
}

}  // namespace isoextract::mesh

#include "mesh/component_facts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::mesh {
namespace {

// Each chunk is summed by one thread, and the sums are added in order, so that nothing depends on the number of
// threads. Triangles follow the order of the grid, so a chunk has few components.
constexpr std::size_t kChunk = 1 << 14;

struct PartialSum {
  std::uint32_t component = 0;
  std::uint64_t triangles = 0;
  double area = 0;
  double volume = 0;
  glm::vec3 min{std::numeric_limits<float>::infinity()};
  glm::vec3 max{-std::numeric_limits<float>::infinity()};
};

std::vector<PartialSum> sums_of_chunk(const Mesh& mesh, const Components& components, const glm::dmat3& to_metric,
                                      double handedness, std::size_t chunk) {
  std::vector<PartialSum> sums;
  const glm::dvec3 apex(mesh.positions[0]);
  const std::size_t end = std::min(mesh.triangles.size(), (chunk + 1) * kChunk);
  for (std::size_t i = chunk * kChunk; i < end; ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    if (has_repeated_index(t)) continue;
    const std::uint32_t component = components.of_vertex(t.x);
    auto sum = std::find_if(sums.rbegin(), sums.rend(), [&](const auto& s) { return s.component == component; });
    if (sum == sums.rend()) {
      sums.push_back({.component = component});
      sum = sums.rbegin();
    }
    const glm::dvec3 a = to_metric * (glm::dvec3(mesh.positions[t.x]) - apex);
    const glm::dvec3 b = to_metric * (glm::dvec3(mesh.positions[t.y]) - apex);
    const glm::dvec3 c = to_metric * (glm::dvec3(mesh.positions[t.z]) - apex);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    ++sum->triangles;
    sum->area += glm::length(normal) / 2;
    sum->volume += handedness * glm::dot(a, normal) / 6;
    for (int corner = 0; corner < 3; ++corner) {
      sum->min = glm::min(sum->min, mesh.positions[t[corner]]);
      sum->max = glm::max(sum->max, mesh.positions[t[corner]]);
    }
  }
  return sums;
}

std::vector<ComponentFacts> measure(const Mesh& mesh, const Components& components, const glm::dmat3& to_metric,
                                    const std::vector<Topology>& topology) {
  std::vector<ComponentFacts> facts(components.count());
  if (facts.empty()) return facts;
  // A mirroring map must not turn shells inside out.
  const double handedness = glm::determinant(to_metric) < 0 ? -1 : 1;
  std::vector<std::vector<PartialSum>> chunks((mesh.triangles.size() + kChunk - 1) / kChunk);
  for_each_index(chunks.size(), [&](std::size_t chunk) {
    chunks[chunk] = sums_of_chunk(mesh, components, to_metric, handedness, chunk);
  });
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (ComponentFacts& fact : facts) fact.bounds = {glm::dvec3(kInfinity), glm::dvec3(-kInfinity)};
  for (const auto& chunk : chunks) {
    for (const PartialSum& sum : chunk) {
      ComponentFacts& fact = facts[sum.component];
      fact.triangles += sum.triangles;
      fact.area += sum.area;
      fact.volume += sum.volume;
      fact.bounds.min = glm::min(fact.bounds.min, mesh.origin + glm::dvec3(sum.min));
      fact.bounds.max = glm::max(fact.bounds.max, mesh.origin + glm::dvec3(sum.max));
    }
  }
  for (std::size_t i = 0; i < facts.size(); ++i) facts[i].topology = topology[i];
  return facts;
}

}  // namespace

Result<std::vector<ComponentFacts>> measure_components(const Mesh& mesh, const Components& components,
                                                       const glm::dmat3& to_metric, const Context& context) {
  auto topology = TRY(measure_topology(mesh, components, context));
  const std::string what = mesh.name + ": the sizes of its components";
  const auto memory = TRY(context.reserve(2 * components.count() * sizeof(PartialSum), what));
  try {
    return measure(mesh, components, to_metric, topology);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::mesh

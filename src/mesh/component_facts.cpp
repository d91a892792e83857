#include "mesh/component_facts.hpp"

#include <algorithm>
#include <new>
#include <string>
#include <utility>

#include "base/allocation_error.hpp"
#include "base/parallel.hpp"
#include "mesh/detail/triangle_sums.hpp"

namespace isoextract::mesh {
namespace {

std::vector<ComponentFacts> measure(const Mesh& mesh, const Components& components, const glm::dmat3& to_metric,
                                    const std::vector<Topology>& topology) {
  std::vector<ComponentFacts> facts = facts_without_triangles(components.count());
  if (facts.empty()) return facts;
  const SumSpace space{glm::dvec3(mesh.positions[0]), to_metric, glm::determinant(to_metric) < 0 ? -1.0 : 1.0};
  std::vector<std::vector<ComponentSum>> chunks((mesh.triangles.size() + kComponentChunk - 1) / kComponentChunk);
  for_each_index(chunks.size(), [&](std::size_t chunk) {
    const std::size_t first = chunk * kComponentChunk;
    const std::size_t count = std::min(kComponentChunk, mesh.triangles.size() - first);
    add_triangles(chunks[chunk], mesh.positions.span(), mesh.triangles.span().subspan(first, count), space,
                  [&](std::uint32_t vertex) { return components.of_vertex(vertex); });
  });
  for (const auto& chunk : chunks) add_chunk(facts, chunk, mesh.origin);
  for (std::size_t i = 0; i < facts.size(); ++i) facts[i].topology = topology[i];
  return facts;
}

}  // namespace

Result<std::vector<ComponentFacts>> measure_components(const Mesh& mesh, const Components& components,
                                                       const glm::dmat3& to_metric, const Context& context) {
  auto topology = TRY(measure_topology(mesh, components, context));
  const std::string what = mesh.name + ": the sizes of its components";
  const auto memory = TRY(context.reserve(2 * components.count() * sizeof(ComponentSum), what));
  try {
    return measure(mesh, components, to_metric, topology);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::mesh

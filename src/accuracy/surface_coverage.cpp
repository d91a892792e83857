#include "accuracy/surface_coverage.hpp"

#include <algorithm>
#include <atomic>
#include <vector>

#include "base/parallel.hpp"
#include "mesh/components.hpp"

namespace isoextract::accuracy {
namespace {

// Returns 1 for each component with a vertex inside `kept`.
std::vector<std::uint8_t> components_kept(const mesh::Mesh& surface, const mesh::Components& components,
                                          std::span<const mesh::HalfSpace> kept) {
  std::vector<std::uint8_t> counts(components.count(), kept.empty() ? 1 : 0);
  for (std::size_t v = 0; v < surface.positions.size() && !kept.empty(); ++v) {
    const std::uint32_t label = components.of_vertex(v);
    if (label < counts.size() && is_kept(surface.position(v), kept)) counts[label] = 1;
  }
  return counts;
}

// Counts the components with counts[c] = 1 that are the nearest component of some vertex of `mesh`.
std::uint64_t count_found(const mesh::Mesh& mesh, const mesh::Mesh& surface, const mesh::TriangleTree& tree,
                          const mesh::Components& components, std::span<const std::uint8_t> counts,
                          const Context& context) {
  std::vector<std::uint8_t> found(components.count(), 0);
  for_each_range(mesh.positions.size(), 1 << 12, [&](std::size_t begin, std::size_t end) {
    std::uint32_t near = 0;
    for (std::size_t v = begin; v != end && !context.cancelled(); ++v) {
      near = tree.nearest(mesh.position(v) - surface.origin, near).slot;
      const std::uint32_t label = components.of_vertex(surface.triangles[tree.triangle(near)].x);
      if (label < found.size()) std::atomic_ref(found[label]).store(1, std::memory_order_relaxed);
    }
    context.progress().advance(end - begin);
  });
  std::uint64_t both = 0;
  for (std::size_t c = 0; c < found.size(); ++c) both += found[c] != 0 && counts[c] != 0 ? 1 : 0;
  return both;
}

}  // namespace

bool is_kept(const glm::dvec3& p, std::span<const mesh::HalfSpace> kept) {
  return std::ranges::all_of(kept, [&](const mesh::HalfSpace& side) { return side.depth(p) >= 0; });
}

std::uint64_t coverage_bytes(std::uint64_t vertices, std::uint64_t triangles) {
  return mesh::Components::bytes(vertices) + 2 * std::min(vertices, triangles);
}

void count_components(const mesh::Mesh& mesh, const mesh::Mesh& surface, const mesh::TriangleTree* tree,
                      std::span<const mesh::HalfSpace> kept, const Context& context, SurfaceCoverage& coverage) {
  const mesh::Components components(surface.triangles.span(), surface.positions.size());
  const std::vector<std::uint8_t> counts = components_kept(surface, components, kept);
  coverage.components = coverage.lost = static_cast<std::uint64_t>(std::ranges::count(counts, 1));
  if (mesh.triangles.empty() || tree == nullptr) return;
  context.progress().begin("counting lost components", mesh.positions.size());
  coverage.lost -= count_found(mesh, surface, *tree, components, counts, context);
}

}  // namespace isoextract::accuracy

#include "measure/surface_coverage.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <tuple>
#include <vector>

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include "measure/detail/index_mesh.hpp"
#include "measure/detail/reduction.hpp"
#include "mesh/components.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::measure {
namespace {

// The samples of `field` in the region of `grid`.
std::optional<field::IndexBox> region_in_field(const field::IndexBox& region, const field::ScalarField& field,
                                               const field::ScalarField& grid) {
  const field::Affine field_from_grid = field.index_to_file.inverse().after(grid.index_to_file);
  const field::Box box = field::image_of(field_from_grid, {glm::dvec3(region.min), glm::dvec3(region.max)});
  constexpr double kRounding = 1e-9;
  const field::IndexBox whole{glm::ivec3(glm::ceil(box.min - kRounding)), glm::ivec3(glm::floor(box.max + kRounding))};
  if (glm::any(glm::lessThan(whole.max - whole.min, glm::ivec3(1)))) return std::nullopt;
  return whole;
}

// Which component each triangle of a tree is of, which knows its triangles by their corners alone.
std::vector<std::uint32_t> component_of_slots(const mesh::Mesh& mesh, const mesh::Components& components,
                                              const mesh::TriangleTree& tree) {
  const auto key = [](const glm::vec3& p) { return std::tuple(p.x, p.y, p.z); };
  std::vector<std::uint32_t> order(mesh.positions.size());
  for (std::size_t v = 0; v < order.size(); ++v) order[v] = static_cast<std::uint32_t>(v);
  // Vertices at one place, of which there are some only far from the origin, are one here.
  tbb::parallel_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::tuple(key(mesh.positions[a]), a) < std::tuple(key(mesh.positions[b]), b);
  });
  std::vector<std::uint32_t> labels(tree.size());
  tbb::parallel_for(PointRange(0, labels.size()), [&](const PointRange& range) {
    for (std::size_t slot = range.begin(); slot != range.end(); ++slot) {
      const auto wanted = key(tree.corners(static_cast<std::uint32_t>(slot)).a);
      const auto found = std::ranges::lower_bound(order, wanted, {},
                                                  [&](std::uint32_t vertex) { return key(mesh.positions[vertex]); });
      labels[slot] = components.of_vertex(*found);
    }
  });
  return labels;
}

bool is_kept(const glm::dvec3& p, std::span<const mesh::HalfSpace> clipped) {
  return std::ranges::all_of(clipped, [&](const mesh::HalfSpace& kept) { return kept.depth(p) >= 0; });
}

// 1 for each that has a vertex where the mesh was kept.
std::vector<std::uint8_t> components_kept(const mesh::Mesh& surface, const mesh::Components& components,
                                          std::span<const mesh::HalfSpace> clipped) {
  std::vector<std::uint8_t> counts(components.count(), clipped.empty() ? 1 : 0);
  for (std::size_t v = 0; v < surface.positions.size() && !clipped.empty(); ++v) {
    const std::uint32_t label = components.of_vertex(v);
    if (label < counts.size() && is_kept(surface.position(v), clipped)) counts[label] = 1;
  }
  return counts;
}

// Those that a vertex of `mesh` is nearest to.
std::uint64_t count_found(const mesh::Mesh& mesh, const mesh::Mesh& surface, const mesh::Components& components,
                          std::span<const std::uint8_t> counts, const Context& context) {
  const mesh::TriangleTree tree(surface.positions.span(), surface.triangles.span());
  const std::vector<std::uint32_t> labels = component_of_slots(surface, components, tree);
  std::vector<std::uint8_t> found(components.count(), 0);
  tbb::parallel_for(PointRange(0, mesh.positions.size(), 1 << 12), [&](const PointRange& range) {
    std::uint32_t near = 0;
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      near = tree.nearest(mesh.position(v) - surface.origin, near).slot;
      const std::uint32_t label = labels[near];
      if (label < found.size()) std::atomic_ref(found[label]).store(1, std::memory_order_relaxed);
    }
    context.progress().advance(range.size());
  });
  std::uint64_t both = 0;
  for (std::size_t c = 0; c < found.size(); ++c) both += found[c] != 0 && counts[c] != 0 ? 1 : 0;
  return both;
}

std::uint64_t bytes_of(const mesh::Mesh& mesh, const mesh::Mesh& surface) {
  const std::uint64_t vertices = surface.positions.size();
  const std::uint64_t triangles = surface.triangles.size();
  // One tree after the other.
  const std::uint64_t looking_back = mesh::TriangleTree::bytes(mesh.triangles.size());
  const std::uint64_t looking_forth =
      mesh::TriangleTree::bytes(triangles) + sizeof(std::uint32_t) * (vertices + triangles) + 2 * vertices;
  return mesh::Components::bytes(vertices) + std::max(looking_back, looking_forth);
}

ErrorStatistics distances_from(const mesh::Mesh& mesh, const mesh::Mesh& surface, const IndexMesh& placed,
                               std::span<const mesh::HalfSpace> clipped, const Context& context) {
  const mesh::TriangleTree tree(mesh.positions.span(), mesh.triangles.span());
  const glm::dmat3 index_from_output = glm::inverse(placed.output_from_index().linear);
  return reduce_in_order(surface.positions.size(), ErrorAccumulator(placed.voxel()), &context.progress(),
                         [&](const PointRange& range, ErrorAccumulator& sums) {
                           std::uint32_t near = 0;
                           for (std::size_t v = range.begin(); v != range.end(); ++v) {
                             if (!is_kept(surface.position(v), clipped)) continue;
                             const glm::dvec3 p = surface.position(v) - mesh.origin;
                             const mesh::TriangleTree::Nearest nearest = tree.nearest(p, near);
                             near = nearest.slot;
                             const double world = std::sqrt(nearest.distance_squared);
                             const double voxels = glm::length(index_from_output * (nearest.point - p));
                             sums.add({voxels, world}, 1, surface.position(v));
                           }
                         })
      .result();
}

}  // namespace

Result<std::optional<SurfaceCoverage>> measure_surface_coverage(const mesh::Mesh& mesh, const field::ScalarField& field,
                                                                const extract::ExtractOptions& extracted,
                                                                const field::ScalarField* grid,
                                                                std::span<const mesh::HalfSpace> clipped,
                                                                const Context& context) {
  const IndexMesh placed(mesh, field, extracted, grid);
  extract::ExtractOptions options = extracted;
  options.method = extract::Method::mc;
  options.cap = false;
  options.smooth_normals = false;
  options.edge_keys = false;
  options.output_from_index = placed.output_from_index();
  if (grid != nullptr && extracted.region) {
    options.region = region_in_field(*extracted.region, field, *grid);
    if (!options.region) return std::nullopt;
  }
  const auto extraction = extract::make_cpu_extractor()->extract(field, options, context);
  if (!extraction) return tl::unexpected(extraction.error());
  const mesh::Mesh& surface = extraction->mesh;
  const auto memory = context.reserve(bytes_of(mesh, surface), "what the mesh lost of the surface of its data");
  if (!memory) return tl::unexpected(memory.error());

  const mesh::Components components(surface.triangles.span(), surface.positions.size());
  SurfaceCoverage coverage;
  const std::vector<std::uint8_t> counts = components_kept(surface, components, clipped);
  coverage.components = coverage.lost = static_cast<std::uint64_t>(std::ranges::count(counts, 1));
  if (mesh.triangles.empty() || surface.triangles.empty()) return coverage;
  context.progress().begin("measuring what was lost", surface.positions.size() + mesh.positions.size());
  coverage.distances = distances_from(mesh, surface, placed, clipped, context);
  coverage.lost -= count_found(mesh, surface, components, counts, context);
  return coverage;
}

}  // namespace isoextract::measure

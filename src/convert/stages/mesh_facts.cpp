#include "convert/stages/mesh_facts.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <new>
#include <utility>

#include "base/allocation_error.hpp"
#include "convert/stages/surface_stages.hpp"
#include "mesh/component_facts.hpp"
#include "mesh/components.hpp"
#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"

namespace isoextract::convert {
namespace {

constexpr std::size_t kMostComponentsTold = 100;

Figures figures_of(const mesh::ComponentFacts& facts) {
  const bool closed = facts.is_closed();
  return {{Key::triangles, facts.triangles},
          {Key::closed, closed},
          {Key::cavity, facts.is_cavity()},
          {Key::genus, closed ? Value(facts.topology.genus()) : Value()},
          {Key::area, facts.area},
          {Key::volume, closed ? Value(facts.volume) : Value()},
          {Key::bounds, Value(field::Box{facts.bounds.min, facts.bounds.max})}};
}

// Returns the largest components by area, and the count of the others.
Result<Figures> measure_table(const mesh::Mesh& mesh, const Context& context) {
  const std::string what = mesh.name + ": the components of its surface";
  const auto labels = TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), what));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const auto list = TRY(context.reserve(components.count() * sizeof(mesh::ComponentFacts), what));
  auto facts = TRY(measure_components(mesh, components, glm::dmat3(1.0), context));
  std::ranges::stable_sort(facts, std::greater<>(), &mesh::ComponentFacts::area);
  const std::size_t told = std::min(facts.size(), kMostComponentsTold);
  Value::List largest;
  for (std::size_t i = 0; i < told; ++i) largest.push_back(Value(figures_of(facts[i])));
  std::uint64_t triangles_of_others = 0;
  for (std::size_t i = told; i < facts.size(); ++i) triangles_of_others += facts[i].triangles;
  return Figures{{Key::largest, std::move(largest)},
                 {Key::others, Figures{{Key::components, facts.size() - told}, {Key::triangles, triangles_of_others}}}};
}

Result<Figures> component_table(const mesh::Mesh& mesh, const Context& context) {
  try {
    return measure_table(mesh, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        allocation_error(mesh.name + ": the components of its surface need more memory than is available"));
  }
}

}  // namespace

Result<Figures> mesh_facts(const Surface& surface, const Context& context) {
  const mesh::Mesh& mesh = surface.mesh;
  context.progress().begin("measuring", 0);
  const mesh::Topology topology = TRY(mesh::measure_topology(mesh, context));
  const Figures components = TRY(component_table(mesh, context));
  const mesh::MeshSize size = mesh::measure_size(mesh);
  const mesh::Bounds bounds = mesh::measure_bounds(mesh);
  const mesh::Topology& as_read = surface.welded ? *surface.welded : topology;
  const bool closed = as_read.is_closed_oriented_manifold();
  return Figures{{Key::iso, surface.id},
                 {Key::file, ""},
                 {Key::name, mesh.name},
                 {Key::vertices, mesh.positions.size()},
                 {Key::triangles, mesh.triangles.size()},
                 {Key::closed, closed},
                 {Key::open_edges, as_read.open_edges},
                 {Key::nonmanifold_edges, as_read.nonmanifold_edges},
                 {Key::misoriented_edges, as_read.misoriented_edges},
                 {Key::nonmanifold_vertices, as_read.nonmanifold_vertices},
                 {Key::components, topology.components},
                 {Key::genus, closed ? Value(topology.genus()) : Value()},
                 {Key::area, size.area},
                 {Key::volume, closed ? Value(size.volume) : Value()},
                 {Key::zero_area_triangles, size.zero_area_triangles},
                 {Key::euler, topology.euler},
                 {Key::bounds, mesh.positions.empty() ? Value() : Value(field::Box{bounds.min, bounds.max})},
                 {Key::origin, Value(mesh.origin)},
                 {Key::component_table, components}};
}

Figures facts_as_written(Figures facts, const std::string& file, const mesh::Mesh& mesh,
                         const std::optional<Figures>& error, const std::string& grid) {
  set(facts, Key::file, file);
  set(facts, Key::name, mesh.name);
  set(facts, Key::vertices, mesh.positions.size());
  if (error) facts.emplace_back(Key::error, *error);
  if (!grid.empty()) facts.emplace_back(Key::grid, grid);
  return facts;
}

}  // namespace isoextract::convert

#include "convert/stages/mesh_facts.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "mesh/mesh_measures.hpp"

namespace isoextract::convert {
namespace {

constexpr std::size_t kMostComponentsTold = 100;

Figures figures_of(const mesh::ComponentFacts& facts) {
  const bool closed = facts.is_closed();
  return {{Key::triangles, facts.triangles},
          {Key::closed, closed},
          {Key::cavity, facts.faces_inward()},
          {Key::genus, closed ? Value(facts.topology.genus()) : Value()},
          {Key::area, facts.area},
          {Key::volume, closed ? Value(facts.volume) : Value()},
          {Key::bounds, Value(field::Box{facts.bounds.min, facts.bounds.max})}};
}

// Returns the largest components by area, and the count of the others.
Figures component_table(std::vector<mesh::ComponentFacts> facts) {
  std::ranges::stable_sort(facts, std::greater<>(), &mesh::ComponentFacts::area);
  const std::size_t told = std::min(facts.size(), kMostComponentsTold);
  Value::List largest;
  for (std::size_t i = 0; i < told; ++i) largest.push_back(Value(figures_of(facts[i])));
  std::uint64_t triangles_of_others = 0;
  for (std::size_t i = told; i < facts.size(); ++i) triangles_of_others += facts[i].triangles;
  return Figures{{Key::largest, std::move(largest)},
                 {Key::others, Figures{{Key::components, facts.size() - told}, {Key::triangles, triangles_of_others}}}};
}

}  // namespace

Result<Figures> mesh_facts(Surface& surface, const Context& context) {
  const mesh::Mesh& mesh = surface.mesh;
  context.progress().begin("measuring", 0);
  mesh::MeshMeasures measures = TRY(surface.measures ? Result<mesh::MeshMeasures>(std::move(*surface.measures))
                                                     : mesh::measure_mesh(mesh, context));
  const mesh::Topology& topology = measures.topology;
  const mesh::MeshSize& size = measures.size;
  const mesh::Bounds& bounds = measures.bounds;
  const mesh::Topology& as_read = surface.welded ? *surface.welded : topology;
  const bool closed = as_read.is_closed_oriented_manifold();
  return Figures{{Key::iso, surface.id},
                 {Key::file, ""},
                 {Key::name, mesh.name},
                 {Key::vertices, surface.vertices()},
                 {Key::triangles, surface.triangles()},
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
                 {Key::bounds, surface.vertices() == 0 ? Value() : Value(field::Box{bounds.min, bounds.max})},
                 {Key::origin, Value(mesh.origin)},
                 {Key::component_table, component_table(std::move(measures.components))}};
}

Figures facts_as_written(const Surface& surface, const std::string& file, const std::string& grid) {
  Figures facts = *surface.facts;
  set(facts, Key::file, file);
  set(facts, Key::name, surface.mesh.name);
  set(facts, Key::vertices, surface.vertices());
  if (surface.error) facts.emplace_back(Key::error, *surface.error);
  if (!grid.empty()) facts.emplace_back(Key::grid, grid);
  return facts;
}

}  // namespace isoextract::convert

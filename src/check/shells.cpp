#include "check/shells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/shells.hpp"

namespace isoextract::check {
namespace {

constexpr double kBoundless = std::numeric_limits<double>::infinity();

// Returns the vertex with the largest x of each component, the first of equal ones.
std::vector<std::uint32_t> rightmost_vertices(const mesh::Mesh& mesh, const mesh::Components& components) {
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> rightmost(components.count(), kNone);
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t c = components.of_vertex(v);
    if (c == mesh::Components::kNone) continue;
    if (rightmost[c] == kNone || mesh.positions[v].x > mesh.positions[rightmost[c]].x) rightmost[c] = v;
  }
  return rightmost;
}

// Returns the normal with twice the triangle's area as its length.
glm::dvec3 area_vector(const mesh::Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]);
  return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

// Adds in the order of vertices and triangles, so that sums do not depend on threads.
std::vector<Component> measure_components(const mesh::Mesh& mesh, const mesh::Components& components,
                                          const BoundaryDefects& defects) {
  std::vector<Component> result(components.count());
  const std::vector<std::uint32_t> apexes = rightmost_vertices(mesh, components);
  for (std::size_t c = 0; c < result.size(); ++c) {
    result[c].edges = defects.components[c];
    result[c].bounds = {glm::dvec3(kBoundless), glm::dvec3(-kBoundless)};
  }
  for (const BoundaryLoop& loop : defects.loops) ++result[loop.component].loops;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::uint32_t c = components.of_vertex(v);
    if (c == mesh::Components::kNone) continue;
    Component& component = result[c];
    const glm::dvec3 place = mesh.position(v);
    ++component.vertices;
    component.bounds.min = glm::min(component.bounds.min, place);
    component.bounds.max = glm::max(component.bounds.max, place);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh::has_repeated_index(t)) continue;
    const std::uint32_t number = components.of_vertex(t.x);
    Component& component = result[number];
    ++component.triangles;
    // Relative to a vertex of the component, which avoids cancellation.
    const glm::dvec3 apex(mesh.positions[apexes[number]]);
    const glm::dvec3 normal = area_vector(mesh, t);
    component.area += glm::length(normal) / 2;
    component.volume += glm::dot(glm::dvec3(mesh.positions[t.x]) - apex, normal) / 6;
  }
  for (Component& component : result) {
    const EdgeDefects& edges = component.edges;
    if (edges.nonmanifold + edges.misoriented + edges.nonmanifold_vertices == 0) {
      const auto edge_count = static_cast<std::int64_t>((3 * component.triangles + edges.open) / 2);
      const std::int64_t euler =
          static_cast<std::int64_t>(component.vertices) - edge_count + static_cast<std::int64_t>(component.triangles);
      component.genus = (2 - static_cast<std::int64_t>(component.loops) - euler) / 2;
    }
  }
  return result;
}

// Sets the type of components without an inside, and their volume to 0. Other components are bodies for now.
Result<void> find_insides(const mesh::Mesh& mesh, const mesh::Components& components, std::vector<Component>& all,
                          const Context& context) {
  std::uint64_t unclear = 0;  // triangles with non-manifold edges in their component: counting edge directions decides
  for (Component& component : all) {
    component.shell = component.edges.open > 0          ? Shell::open
                      : component.edges.misoriented > 0 ? Shell::not_oriented
                                                        : Shell::body;
    if (component.shell == Shell::body && component.edges.nonmanifold > 0) unclear += component.triangles;
  }
  struct HalfEdge {
    std::uint32_t low;
    std::uint32_t high;
    bool rises;
  };
  const auto memory = TRY(context.reserve(3 * unclear * sizeof(HalfEdge), mesh.name + ": edges where sheets touch"));
  std::vector<HalfEdge> edges;
  edges.reserve(3 * unclear);
  for (const glm::uvec3& t : mesh.triangles) {
    if (unclear == 0 || mesh::has_repeated_index(t)) continue;
    const Component& component = all[components.of_vertex(t.x)];
    if (component.shell != Shell::body || component.edges.nonmanifold == 0) continue;
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t from = t[c];
      const std::uint32_t to = t[(c + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to), from < to});
    }
  }
  std::ranges::sort(edges, {}, [](const HalfEdge& edge) { return std::pair(edge.low, edge.high); });
  for (std::size_t begin = 0; begin < edges.size();) {
    std::int64_t more_rise = 0;
    std::size_t end = begin;
    while (end < edges.size() && edges[end].low == edges[begin].low && edges[end].high == edges[begin].high) {
      more_rise += edges[end++].rises ? 1 : -1;
    }
    if (more_rise != 0) all[components.of_vertex(edges[begin].low)].shell = Shell::not_oriented;
    begin = end;
  }
  for (Component& component : all) {
    if (!component.has_inside()) component.volume = 0;
  }
  return {};
}

mesh::Facing facing_of(const Component& component) {
  if (!component.has_inside()) return mesh::Facing::open;
  return component.volume < 0 ? mesh::Facing::inward : mesh::Facing::outward;
}

Shell shell_of(const Component& component) {
  if (!component.has_inside()) return component.shell;
  if (component.enclosing_shells % 2 == 0) return component.volume < 0 ? Shell::inside_out : Shell::body;
  return component.volume < 0 ? Shell::cavity : Shell::nested;
}

// An open surface, which ends at the data boundary, may have cavities. It has no inside, so no ray test can find them.
void find_undecided(std::vector<Component>& all) {
  std::vector<mesh::Bounds> open;
  for (const Component& component : all) {
    if (component.shell == Shell::open) open.push_back(component.bounds);
  }
  std::ranges::sort(open, std::greater(), [](const mesh::Bounds& bounds) { return bounds.max.x - bounds.min.x; });
  for (Component& component : all) {
    if (component.shell != Shell::inside_out) continue;
    const bool may_be_cavity = std::ranges::any_of(open, [&](const mesh::Bounds& bounds) {
      return glm::all(glm::lessThanEqual(bounds.min, component.bounds.min)) &&
             glm::all(glm::greaterThanEqual(bounds.max, component.bounds.max));
    });
    if (may_be_cavity) component.shell = Shell::undecided;
  }
}

}  // namespace

Result<std::vector<Component>> describe_components(const mesh::Mesh& mesh, const mesh::Components& components,
                                                   const BoundaryDefects& defects, const Context& context) {
  const std::string what = fmt::format("{}: its components", mesh.name);
  const std::uint64_t of_one = sizeof(Component) + sizeof(mesh::Surroundings) + sizeof(std::uint32_t);
  const auto memory = TRY(context.reserve(components.count() * of_one, what));
  try {
    std::vector<Component> all = measure_components(mesh, components, defects);
    TRY(find_insides(mesh, components, all, context));
    mesh::ShellQuery question;
    for (const Component& component : all) question.facing.push_back(facing_of(component));
    if (all.size() - std::ranges::count(question.facing, mesh::Facing::open) > 1) {
      const auto surroundings = TRY(find_enclosing_shells(mesh, components, question, context));
      for (std::size_t c = 0; c < all.size(); ++c) {
        all[c].enclosing_shells = static_cast<std::uint32_t>(surroundings[c].around.size());
      }
    }
    for (Component& component : all) component.shell = shell_of(component);
    find_undecided(all);
    return all;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

}  // namespace isoextract::check

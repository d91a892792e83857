#include "check/mesh_check.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/counted.hpp"
#include "mesh/coincident_vertices.hpp"
#include "mesh/components.hpp"

namespace isoextract::check {
namespace {

constexpr const char* kPlacesText = "the vertices at equal positions";

// Copies positions and name; the triangles refer to the first vertex at each position.
mesh::Mesh with_joined_triangles(const mesh::Mesh& mesh, const mesh::CoincidentVertices& places) {
  mesh::Mesh joined;
  joined.name = mesh.name;
  joined.positions = Buffer<glm::vec3>(mesh.positions.size());
  std::copy(mesh.positions.begin(), mesh.positions.end(), joined.positions.begin());
  joined.triangles = Buffer<glm::uvec3>(mesh.triangles.size());
  std::transform(mesh.triangles.begin(), mesh.triangles.end(), joined.triangles.begin(),
                 [&](const glm::uvec3& t) { return places.of_triangle(t); });
  return joined;
}

Result<void> find_coincident_vertices(const mesh::Mesh& mesh, const Context& context, MeshCheck& check) {
  const std::string what = fmt::format("{}: {}", mesh.name, kPlacesText);
  auto memory = TRY(context.reserve(mesh::CoincidentVertices::bytes(mesh.positions.size()), what));
  const mesh::CoincidentVertices places(mesh.positions.span());
  check.repeated_vertices = places.repeated();
  if (check.repeated_vertices == 0 || check.topology.open_edges == 0) return {};
  const auto copy = TRY(context.reserve(mesh.positions.size_bytes() + mesh.triangles.size_bytes(), what));
  check.welded = TRY(mesh::measure_topology(with_joined_triangles(mesh, places), context));
  return {};
}

Result<void> check_components(const mesh::Mesh& mesh, const Context& context, MeshCheck& check) {
  const auto memory = TRY(
      context.reserve(mesh::Components::bytes(mesh.positions.size()), fmt::format("{}: its components", mesh.name)));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  auto defects = TRY(find_boundary_defects(mesh, check.topology, components, context));
  check.memory =
      TRY(context.reserve(components.count() * sizeof(Component) + defects.loops.size() * sizeof(BoundaryLoop),
                          fmt::format("{}: the table of its components", mesh.name)));
  auto described = TRY(describe_components(mesh, components, defects, context));
  // Only vertices of triangles count: an unused vertex is not on the surface.
  for (const Component& component : described) {
    if (&component == &described.front()) check.bounds = component.bounds;
    check.bounds = {glm::min(check.bounds.min, component.bounds.min), glm::max(check.bounds.max, component.bounds.max)};
  }
  check.loops = std::move(defects.loops);
  check.components = std::move(described);
  return {};
}

Result<MeshCheck> run_checks(const mesh::Mesh& mesh, const Context& context) {
  MeshCheck check;
  check.vertices = mesh.positions.size();
  check.triangles = mesh.triangles.size();
  context.progress().begin("checking edges and vertices", 0);
  check.topology = TRY(mesh::measure_topology(mesh, context));
  check.size = mesh::measure_size(mesh);
  for (auto* const look : {find_coincident_vertices, check_components}) {
    TRY(context.check());
    TRY(look(mesh, context, check));
  }
  check.intersections = TRY(mesh::find_self_intersections(mesh, {}, context));
  return check;
}

// Joins the texts whose counts are not 0.
std::string both(const std::string& a, std::uint64_t a_count, const std::string& b, std::uint64_t b_count) {
  if (a_count == 0) return b;
  return b_count == 0 ? a : fmt::format("{}, {}", a, b);
}

std::uint64_t count_violations(Requirement requirement, const MeshCheck& check) {
  switch (requirement) {
    case Requirement::closed: return check.topology.open_edges;
    case Requirement::manifold: return check.topology.nonmanifold_edges + check.topology.nonmanifold_vertices;
    case Requirement::oriented: return check.topology.misoriented_edges;
    case Requirement::outward: return check.count(Shell::inside_out);
    case Requirement::no_self_intersections: return check.intersections.pairs;
    case Requirement::no_zero_area: return check.intersections.zero_area_triangles;
    case Requirement::no_duplicates: return check.intersections.duplicate_triangles;
    case Requirement::no_unused_vertices: return check.topology.unused_vertices;
    case Requirement::one_component: return check.topology.components == 1 ? 0 : check.topology.components;
    case Requirement::normals: break;
  }
  return check.normals ? check.normals->against + check.normals->missing : check.triangles;
}

std::string reason(Requirement requirement, const MeshCheck& check, std::uint64_t count) {
  const mesh::Topology& topology = check.topology;
  switch (requirement) {
    case Requirement::closed:
      return counted(count, "open edge") +
             (check.loops.empty() ? std::string() : " in " + counted(check.loops.size(), "loop"));
    case Requirement::manifold:
      return both(counted(topology.nonmanifold_edges, "edge") + " of more than two triangles",
                  topology.nonmanifold_edges,
                  counted(topology.nonmanifold_vertices, "vertex", "vertices") + " where surfaces touch",
                  topology.nonmanifold_vertices);
    case Requirement::oriented: return counted(count, "edge") + " whose triangles have opposite winding";
    case Requirement::outward: return counted(count, "component") + " inside out";
    case Requirement::no_self_intersections:
      return fmt::format("{}{} of triangles that intersect", check.intersections.at_least ? "more than " : "",
                         counted(count, "pair"));
    case Requirement::no_zero_area: return counted(count, "triangle") + " without area";
    case Requirement::no_duplicates: return counted(count, "triangle") + " with the corners of another";
    case Requirement::no_unused_vertices: return counted(count, "vertex", "vertices") + " in no triangle";
    case Requirement::one_component: return counted(count, "component");
    case Requirement::normals: break;
  }
  if (!check.normals) return "no normals";
  return both(counted(check.normals->against, "corner") + " with a normal against the triangle", check.normals->against,
              counted(check.normals->missing, "corner") + " without a normal", check.normals->missing);
}

}  // namespace

bool MeshCheck::has_volume() const {
  return !components.empty() && topology.repeated_index_triangles == 0 &&
         std::ranges::all_of(components, &Component::has_inside);
}

std::uint64_t MeshCheck::count(Shell shell) const {
  return static_cast<std::uint64_t>(std::ranges::count(components, shell, &Component::shell));
}

Result<MeshCheck> check_mesh(const mesh::Mesh& mesh, const Context& context) {
  try {
    return run_checks(mesh, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        allocation_error(fmt::format("{}: checking it needs more memory than is available", mesh.name)));
  }
}

Result<void> weld_coincident_vertices(mesh::Mesh& mesh, const Context& context) {
  const std::string what = fmt::format("{}: {}", mesh.name, kPlacesText);
  const std::uint64_t vertices = mesh.positions.size();
  const auto memory = TRY(context.reserve(
      mesh::CoincidentVertices::bytes(vertices) + vertices * (2 * sizeof(std::uint32_t) + mesh::vertex_bytes(mesh)),
      what));
  try {
    const mesh::CoincidentVertices places(mesh.positions.span());
    if (places.repeated() == 0) return {};
    std::vector<std::uint32_t> old_of_new;
    old_of_new.reserve(vertices);
    std::vector<std::uint32_t> new_of_old(vertices);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      const std::uint32_t first = places.of_vertex(v);
      if (first == v) old_of_new.push_back(v);
      new_of_old[v] = first == v ? static_cast<std::uint32_t>(old_of_new.size() - 1) : new_of_old[first];
    }
    mesh::gather_vertices(mesh, old_of_new);
    for (glm::uvec3& t : mesh.triangles) t = {new_of_old[t.x], new_of_old[t.y], new_of_old[t.z]};
    return {};
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " need more memory than is available"));
  }
}

std::optional<std::string> unmet_reason(Requirement requirement, const MeshCheck& check) {
  if (check.triangles == 0) return "no triangles";
  const std::uint64_t count = count_violations(requirement, check);
  if (count == 0 && (requirement != Requirement::one_component || check.topology.components == 1)) return std::nullopt;
  return reason(requirement, check, count);
}

}  // namespace isoextract::check

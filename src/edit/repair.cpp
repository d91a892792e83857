#include "edit/repair.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <new>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "edit/detail/edge_uses.hpp"
#include "edit/detail/fill_holes.hpp"
#include "edit/detail/orient_triangles.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/coincident_vertices.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/split_vertices.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

std::uint64_t count_used_vertices(const mesh::Mesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const glm::uvec3& triangle : mesh.triangles) used[triangle.x] = used[triangle.y] = used[triangle.z] = true;
  return static_cast<std::uint64_t>(std::ranges::count(used, true));
}

// Keeps the triangles for which keep(t) is true.
template <class Keep>
void keep_triangles(mesh::Mesh& mesh, const Keep& keep) {
  std::size_t kept = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (keep(t)) mesh.triangles[kept++] = mesh.triangles[t];
  }
  if (kept == mesh.triangles.size()) return;
  Buffer<glm::uvec3> rest(kept);
  std::copy_n(mesh.triangles.begin(), kept, rest.begin());
  mesh.triangles = std::move(rest);
}

bool have_equal_attributes(const mesh::Mesh& mesh, std::uint32_t a, std::uint32_t b) {
  return std::ranges::all_of(mesh.attributes, [&](const mesh::Attribute& attribute) {
    return std::ranges::equal(attribute.at(a), attribute.at(b));
  });
}

// Merges vertices of boundary or zero-length edges at equal positions. Counts the vertices merged into another.
void weld(mesh::Mesh& mesh, RepairFigures& figures) {
  const std::size_t vertices = mesh.positions.size();
  const mesh::CoincidentVertices places(mesh.positions.span());
  if (places.repeated() == 0) return;
  std::vector<bool> joins(vertices);
  EdgeUses(mesh.triangles.span()).for_each_edge([&](std::span<const EdgeUse> edge) {
    const bool has_length = places.of_vertex(edge[0].low) != places.of_vertex(edge[0].high);
    if (edge.size() != 1 && has_length) return;
    joins[edge[0].low] = true;
    joins[edge[0].high] = true;
  });
  std::vector<std::uint32_t> first_at(vertices, kNone);  // per position: the first vertex, into which others merge
  std::vector<std::uint32_t> target(vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    target[v] = v;
    if (!joins[v]) continue;
    std::uint32_t& first = first_at[places.of_vertex(v)];
    if (first == kNone) first = v;
    target[v] = first;
    if (first == v) continue;
    ++figures.welded;
    figures.values_lost += have_equal_attributes(mesh, first, v) ? 0 : 1;
  }
  for (glm::uvec3& t : mesh.triangles) t = {target[t.x], target[t.y], target[t.z]};
}

bool has_no_area(const mesh::Mesh& mesh, const glm::uvec3& t) {
  return mesh::has_repeated_index(t) ||
         mesh::are_collinear(glm::dvec3(mesh.positions[t.x]), glm::dvec3(mesh.positions[t.y]),
                             glm::dvec3(mesh.positions[t.z]));
}

// Returns the side of a triangle opposite its middle corner.
std::uint8_t longest_side(const mesh::Mesh& mesh, const glm::uvec3& t) {
  std::array<double, 3> lengths{};
  for (int side = 0; side < 3; ++side) {
    lengths[static_cast<std::size_t>(side)] =
        glm::distance(glm::dvec3(mesh.positions[t[side]]), glm::dvec3(mesh.positions[t[(side + 1) % 3]]));
  }
  return static_cast<std::uint8_t>(std::ranges::max_element(lengths) - lengths.begin());
}

// Flips the longest side of a triangle without area: its middle corner splits the neighbor there. Returns false without
// such a neighbor, or if an edge would occur twice or a new triangle had no area.
bool flip(mesh::Mesh& mesh, const EdgeUses& uses, std::uint32_t t, std::vector<bool>& changed) {
  const glm::uvec3 flat = mesh.triangles[t];
  const std::uint8_t side = longest_side(mesh, flat);
  const std::uint32_t from = flat[side];
  const std::uint32_t to = flat[(side + 1) % 3];
  const std::uint32_t middle = flat[(side + 2) % 3];
  const auto edge = uses.of_edge(from, to);
  if (edge.size() != 2) return false;
  const EdgeUse& use = edge[0].triangle == t ? edge[1] : edge[0];
  if (changed[use.triangle]) return false;
  const glm::uvec3 other = mesh.triangles[use.triangle];
  const std::uint32_t apex = other[(use.side + 2) % 3];
  if (apex == middle || !uses.of_edge(middle, apex).empty()) return false;
  const glm::uvec3 first{use.from(), middle, apex};
  const glm::uvec3 second{middle, use.to(), apex};
  if (has_no_area(mesh, first) || has_no_area(mesh, second)) return false;
  mesh.triangles[use.triangle] = first;
  mesh.triangles[t] = second;
  changed[use.triangle] = true;
  changed[t] = true;
  return true;
}

// Returns the number of triangles without area that were dropped or got area.
Result<std::uint64_t> remove_flat(mesh::Mesh& mesh, const Context& context) {
  const std::size_t before = mesh.triangles.size();
  keep_triangles(mesh, [&](std::uint32_t t) { return !mesh::has_repeated_index(mesh.triangles[t]); });
  std::uint64_t removed = before - mesh.triangles.size();
  for (;;) {
    TRY(context.check());
    std::vector<std::uint32_t> flat;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      if (has_no_area(mesh, mesh.triangles[t])) flat.push_back(t);
    }
    if (flat.empty()) return removed;
    const EdgeUses uses(mesh.triangles.span());
    std::vector<bool> changed(mesh.triangles.size());
    std::uint64_t flipped = 0;
    for (const std::uint32_t t : flat) flipped += !changed[t] && flip(mesh, uses, t, changed) ? 1 : 0;
    removed += flipped;
    if (flipped > 0) continue;
    // The remaining triangles have no neighbor that their middle corner could split.
    std::vector<bool> drops(mesh.triangles.size());
    for (const std::uint32_t t : flat) drops[t] = true;
    keep_triangles(mesh, [&](std::uint32_t t) { return !drops[t]; });
    return removed + flat.size();
  }
}

// Returns the number of dropped triangles.
std::uint64_t remove_duplicates(mesh::Mesh& mesh) {
  const auto corners = [&](std::uint32_t t) {
    std::array<std::uint32_t, 3> sorted{mesh.triangles[t].x, mesh.triangles[t].y, mesh.triangles[t].z};
    std::ranges::sort(sorted);
    return sorted;
  };
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::sort(order, {}, [&](std::uint32_t t) { return std::pair(corners(t), t); });
  std::vector<bool> drops(order.size());
  std::uint64_t dropped = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (corners(order[i]) != corners(order[i - 1])) continue;
    drops[order[i]] = true;
    ++dropped;
  }
  keep_triangles(mesh, [&](std::uint32_t t) { return !drops[t]; });
  return dropped;
}

Result<RepairFigures> repair_reserved(mesh::Mesh& mesh, const RepairOptions& options, const Context& context) {
  RepairFigures figures;
  mesh.normals = {};
  mesh.edges = {};
  figures.unused_removed = mesh.positions.size() - count_used_vertices(mesh);
  weld(mesh, figures);
  TRY(context.check());
  figures.without_area = TRY(remove_flat(mesh, context));
  figures.duplicates = remove_duplicates(mesh);
  TRY(context.check());
  const OrientFigures oriented = orient_patches(mesh, EdgeUses(mesh.triangles.span()));
  figures.turned = oriented.turned;
  figures.contradictions = oriented.contradictions;
  const FillFigures filled = TRY(
      fill_holes(mesh, EdgeUses(mesh.triangles.span()), std::min(options.most_hole_edges, kMostHoleEdges), context));
  figures.holes_filled = filled.filled;
  figures.fill_triangles = filled.triangles;
  figures.holes_left = filled.left;
  figures.holes_too_long = filled.too_long;
  const std::uint64_t used = count_used_vertices(mesh);
  TRY(mesh::split_nonmanifold_vertices(mesh, mesh.name, context));
  figures.vertices_split = mesh.positions.size() - used;
  figures.components_turned = TRY(face_by_nesting(mesh, context));
  return figures;
}

}  // namespace

Result<RepairFigures> repair(mesh::Mesh& mesh, const RepairOptions& options, const Context& context) {
  const Stopwatch watch;
  context.progress().begin("repairing", 0);
  const std::string what = mesh.name + ": repairing it";
  const std::uint64_t triangles = mesh.triangles.size();
  constexpr std::uint64_t kTriangleBytes = 64;  // neighbors, windings and orders
  constexpr std::uint64_t kVertexBytes = 16;
  const auto memory = TRY(context.reserve(EdgeUses::bytes(triangles) + triangles * kTriangleBytes +
                                              mesh.positions.size() * kVertexBytes +
                                              mesh::CoincidentVertices::bytes(mesh.positions.size()),
                                          what));
  try {
    auto figures = TRY(repair_reserved(mesh, options, context));
    figures.time = watch.elapsed();
    return figures;
  } catch (const std::bad_alloc&) {
    return tl::unexpected(allocation_error(what + " needs more memory than is available"));
  }
}

}  // namespace isoextract::edit

#include "edit/detail/cut_cap.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "edit/detail/loop_triangulation.hpp"
#include "mesh/attributes.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/split_vertices.hpp"

namespace isoextract::edit {
namespace {

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;

// The mesh's edges in the plane.
struct PlaneEdges {
  std::vector<VertexPair> boundary;  // boundary edges in the direction of their triangles, sorted
  std::vector<VertexPair> others;    // inner edges, the smaller vertex first
};

PlaneEdges edges_in_plane(const mesh::Mesh& mesh, const mesh::HalfSpace& kept, double on_plane) {
  std::vector<bool> is_on(mesh.positions.size());
  for (std::size_t v = 0; v < is_on.size(); ++v) is_on[v] = std::abs(kept.depth(mesh.position(v))) <= on_plane;
  std::vector<VertexPair> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const VertexPair edge(t[i], t[(i + 1) % 3]);
      if (is_on[edge.first] && is_on[edge.second]) edges.push_back(edge);
    }
  }
  const auto in_both_ways = [](const VertexPair& e) {
    return VertexPair(std::min(e.first, e.second), std::max(e.first, e.second));
  };
  std::ranges::sort(edges, [&](const VertexPair& a, const VertexPair& b) {
    const VertexPair p = in_both_ways(a);
    const VertexPair q = in_both_ways(b);
    return p != q ? p < q : a < b;
  });
  PlaneEdges result;
  for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
    const VertexPair edge = in_both_ways(edges[i]);
    std::size_t rising = 0;
    for (j = i; j < edges.size() && in_both_ways(edges[j]) == edge; ++j) rising += edges[j] == edge ? 1 : 0;
    const std::size_t falling = j - i - rising;
    for (std::size_t n = falling; n < rising; ++n) result.boundary.push_back(edge);
    for (std::size_t n = rising; n < falling; ++n) result.boundary.emplace_back(edge.second, edge.first);
    if (rising > 0 && falling > 0) result.others.push_back(edge);
  }
  std::ranges::sort(result.boundary);
  return result;
}

bool start_at_one_vertex(const VertexPair& a, const VertexPair& b) { return a.first == b.first; }

// Returns for each point the next point of its loop, against the direction of the triangles; nothing if loops do not
// close.
std::optional<std::vector<std::uint32_t>> loops_of(const std::vector<VertexPair>& boundary) {
  // Point n is where boundary[n] starts.
  std::vector<std::uint32_t> next(boundary.size());
  // For the first point at each vertex: how many points of that vertex have a predecessor.
  std::vector<std::uint32_t> entered(boundary.size(), 0);
  for (std::uint32_t n = 0; n < boundary.size(); ++n) {
    const auto at = std::ranges::lower_bound(boundary, VertexPair(boundary[n].second, 0));
    const auto first = static_cast<std::size_t>(at - boundary.begin());
    if (at == boundary.end() || at->first != boundary[n].second) return std::nullopt;
    const std::size_t point = first + entered[first]++;
    if (point >= boundary.size() || boundary[point].first != boundary[n].second) return std::nullopt;
    next[point] = n;
  }
  return next;
}

// Projects along the normal's largest axis, without rounding, as seen from outside the kept side.
glm::dvec2 in_plane(const glm::vec3& p, const mesh::HalfSpace& kept) {
  const glm::dvec3 size = glm::abs(kept.normal);
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const glm::dvec2 seen = mesh::along_axis(glm::dvec3(p), axis);
  return kept.normal[axis] < 0 ? seen : glm::dvec2(seen.y, seen.x);
}

// Gives points closer than `near` one position, for the triangulation only (no vertex moves): rounding may give the
// vertices around a sample on the surface a wrong order.
void merge_places(std::vector<glm::dvec2>& points, double near) {
  if (!(near > 0)) return;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
  const auto cell_of = [&](const glm::dvec2& p) { return glm::i64vec2(glm::floor(p / near)); };
  const auto key_of_cell = [](const glm::i64vec2& cell) {
    return static_cast<std::uint64_t>(cell.x) << 32 ^ (static_cast<std::uint64_t>(cell.y) & 0xFFFFFFFFU);
  };
  const auto place_near = [&](const glm::dvec2& p) -> std::optional<glm::dvec2> {
    const glm::i64vec2 cell = cell_of(p);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const auto found = cells.find(key_of_cell(cell + glm::i64vec2(dx, dy)));
        if (found == cells.end()) continue;
        for (const std::uint32_t n : found->second) {
          if (glm::length(points[n] - p) < near) return points[n];
        }
      }
    }
    return std::nullopt;
  };
  for (std::uint32_t n = 0; n < points.size(); ++n) {
    if (const auto place = place_near(points[n])) {
      points[n] = *place;
    } else {
      cells[key_of_cell(cell_of(points[n]))].push_back(n);
    }
  }
}

Result<void> append(const std::vector<VertexPair>& boundary, const LoopTriangles& cap, mesh::Mesh& mesh,
                    const Context& context) {
  const std::size_t vertices = mesh.positions.size() + cap.midpoints.size();
  const std::size_t triangles = mesh.triangles.size() + cap.triangles.size();
  auto memory = TRY(
      context.reserve(vertices * mesh::vertex_bytes(mesh) + triangles * sizeof(glm::uvec3), "the mesh with its cap"));
  const auto vertex_of = [&](std::uint32_t point) {
    return point < boundary.size() ? boundary[point].first
                                   : static_cast<std::uint32_t>(mesh.positions.size() + (point - boundary.size()));
  };
  Buffer<glm::uvec3> all(triangles);
  glm::uvec3* out = std::ranges::copy(mesh.triangles, all.data()).out;
  for (const glm::uvec3& t : cap.triangles) *out++ = {vertex_of(t.x), vertex_of(t.y), vertex_of(t.z)};
  if (!cap.midpoints.empty()) {
    Buffer<glm::vec3> positions(vertices);
    Buffer<glm::vec3> normals(mesh.normals.empty() ? 0 : vertices);
    std::ranges::copy(mesh.positions, positions.data());
    std::ranges::copy(mesh.normals, normals.data());
    std::size_t at = mesh.positions.size();
    for (const auto& [a, b] : cap.midpoints) {
      const std::uint32_t from = vertex_of(a);
      const std::uint32_t to = vertex_of(b);
      positions[at] = glm::vec3((glm::dvec3(positions[from]) + glm::dvec3(positions[to])) / 2.0);
      if (!mesh.normals.empty()) normals[at] = normals[from];
      ++at;
    }
    for (mesh::Attribute& attribute : mesh.attributes) {
      mesh::Attribute longer = attribute.without_values();
      longer.values = Buffer<std::byte>(vertices * longer.stride());
      std::ranges::copy(attribute.values, longer.values.data());
      at = mesh.positions.size();
      for (const auto& [a, b] : cap.midpoints) {
        mesh::set_interpolated(longer, at++, longer, {vertex_of(a), vertex_of(b), 0.5});
      }
      attribute = std::move(longer);
    }
    mesh.positions = std::move(positions);
    mesh.normals = std::move(normals);
  }
  mesh.triangles = std::move(all);
  mesh.memory = std::move(memory);
  return {};
}

// Returns the first edge between two vertices at one position, in the triangles from `first` on, that is not in
// `refused`.
std::optional<VertexPair> edge_without_length(const mesh::Mesh& mesh, std::size_t first,
                                              const std::vector<VertexPair>& refused) {
  for (std::size_t i = first; i < mesh.triangles.size(); ++i) {
    const glm::uvec3& t = mesh.triangles[i];
    for (int c = 0; c < 3; ++c) {
      const VertexPair edge = std::minmax(std::uint32_t{t[c]}, std::uint32_t{t[(c + 1) % 3]});
      const bool is_one_place = edge.first != edge.second && mesh.positions[edge.first] == mesh.positions[edge.second];
      if (is_one_place && std::ranges::find(refused, edge) == refused.end()) return edge;
    }
  }
  return std::nullopt;
}

// Returns whether the edge's ends have only the other corners of its two triangles in common.
bool may_collapse(const mesh::Mesh& mesh, const VertexPair& edge) {
  std::vector<std::uint32_t> near_first;
  std::vector<std::uint32_t> near_second;
  std::size_t between = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const bool has_first = t.x == edge.first || t.y == edge.first || t.z == edge.first;
    const bool has_second = t.x == edge.second || t.y == edge.second || t.z == edge.second;
    between += has_first && has_second ? 1 : 0;
    for (int c = 0; c < 3; ++c) {
      if (t[c] == edge.first || t[c] == edge.second) continue;
      if (has_first) near_first.push_back(t[c]);
      if (has_second) near_second.push_back(t[c]);
    }
  }
  std::vector<std::uint32_t> common;
  for (auto* const near : {&near_first, &near_second}) {
    std::ranges::sort(*near);
    near->erase(std::unique(near->begin(), near->end()), near->end());
  }
  std::ranges::set_intersection(near_first, near_second, std::back_inserter(common));
  return between == 2 && common.size() == 2;
}

// Merges the copies of a vertex that was split where loops meet, if the cap lies between them: all their triangles then
// form one fan. Removes the cap's two triangles without area between the copies.
Result<void> join_copies(mesh::Mesh& mesh, std::size_t first_of_cap, const std::string& what, const Context& context) {
  std::vector<VertexPair> refused;
  bool joined = false;
  while (const auto edge = edge_without_length(mesh, first_of_cap, refused)) {
    if (!may_collapse(mesh, *edge)) {
      refused.push_back(*edge);
      continue;
    }
    joined = true;
    std::vector<glm::uvec3> kept;
    kept.reserve(mesh.triangles.size());
    for (glm::uvec3 t : mesh.triangles) {
      for (int c = 0; c < 3; ++c) {
        if (t[c] == edge->second) t[c] = edge->first;
      }
      if (t.x != t.y && t.y != t.z && t.z != t.x) kept.push_back(t);
    }
    mesh.triangles = Buffer<glm::uvec3>(kept.size());
    std::ranges::copy(kept, mesh.triangles.begin());
  }
  return joined ? mesh::split_nonmanifold_vertices(mesh, what, context) : Result<void>();
}

}  // namespace

Result<CutCapFigures> cap_cut(mesh::Mesh& mesh, const mesh::HalfSpace& kept, double on_plane, const Context& context) {
  const std::string what = "the cap of a clip plane";
  // Edges in the plane are few, unless the mesh lies in it, so only the flags are reserved yet.
  const auto flags = TRY(context.reserve(mesh.positions.size() / 8 + 8, what));
  PlaneEdges edges = edges_in_plane(mesh, kept, on_plane);
  if (std::ranges::adjacent_find(edges.boundary, start_at_one_vertex) != edges.boundary.end()) {
    TRY(mesh::split_nonmanifold_vertices(mesh, what, context));
    edges = edges_in_plane(mesh, kept, on_plane);
  }
  const auto memory = TRY(context.reserve(edges.boundary.size() * 192 + edges.others.size() * 16, what));
  const auto next = loops_of(edges.boundary);
  if (!next) {
    return fail(ErrorCode::input,
                "the program cannot cap the cut: the surface has a boundary edge or a hole there, so the cut line "
                "is not closed",
                {{Remedy::change, Setting::cuts, "away from the hole"},
                 {Remedy::leave_out, Setting::cap, "the cut then stays open"}});
  }
  std::vector<glm::dvec2> points;
  points.reserve(edges.boundary.size());
  for (const VertexPair& edge : edges.boundary) points.push_back(in_plane(mesh.positions[edge.first], kept));
  // Inner edges as pairs of points instead of vertices.
  std::vector<VertexPair> taken;
  const auto point_at = [&](std::uint32_t vertex) -> std::optional<std::uint32_t> {
    const auto at = std::ranges::lower_bound(edges.boundary, VertexPair(vertex, 0));
    if (at == edges.boundary.end() || at->first != vertex) return std::nullopt;
    return static_cast<std::uint32_t>(at - edges.boundary.begin());
  };
  for (const VertexPair& edge : edges.others) {
    const auto a = point_at(edge.first);
    const auto b = point_at(edge.second);
    if (a && b) taken.emplace_back(std::minmax(*a, *b));
  }
  auto cap = triangulate_loops(points, *next, taken, 0, context);
  if (cap && cap->turned > 0) {
    // Vertices clustered around a sample on the surface may have been rounded independently.
    constexpr double kRoundings = 16;
    merge_places(points, kRoundings * on_plane);
    cap = triangulate_loops(points, *next, taken, kRoundings * on_plane, context);
  }
  if (!cap) return tl::unexpected(std::move(cap.error()));
  const std::size_t first_of_cap = mesh.triangles.size();
  TRY(append(edges.boundary, *cap, mesh, context));
  TRY(join_copies(mesh, first_of_cap, what, context));
  return CutCapFigures{cap->triangles.size(), cap->turned};
}

}  // namespace isoextract::edit

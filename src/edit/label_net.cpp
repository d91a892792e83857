#include "edit/label_net.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <new>
#include <numeric>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

#include "base/allocation_error.hpp"
#include "base/hash.hpp"
#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "edit/detail/collapse_state.hpp"
#include "edit/detail/sheet_collapse.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/coincident_vertices.hpp"

namespace isoextract::edit {
namespace {

constexpr const char* kWhat = "joining the meshes of all labels";

tl::unexpected<Error> no_memory() {
  return tl::unexpected(
      allocation_error(fmt::format("{} needs more memory than is available", kWhat), {Remedy::use, Setting::parts}));
}

std::uint32_t index_of(const glm::uvec3& t, std::uint32_t vertex) { return t.x == vertex ? 0 : t.y == vertex ? 1 : 2; }

// Returns whether two triangles of the same vertices have opposite winding.
bool are_opposite(const glm::uvec3& a, const glm::uvec3& b) {
  return b[static_cast<int>((index_of(b, a.x) + 1) % 3)] == a.z;
}

// Finds triangles by their vertices, in any order.
class TriangleTable {
 public:
  explicit TriangleTable(std::size_t most) {
    std::size_t size = 16;
    while (size < most + most / 2) size *= 2;
    slots_.assign(size, kNone);
  }
  // Returns the number of the triangle with the vertices of `t`. If there is none, adds `number` for it and returns
  // kNone.
  std::uint32_t find_or_add(const glm::uvec3& t, std::span<const glm::uvec3> triangles, std::uint32_t number) {
    const glm::uvec3 key = sorted(t);
    std::size_t slot = hash_coordinates(key.x, key.y, key.z) & (slots_.size() - 1);
    for (; slots_[slot] != kNone; slot = (slot + 1) & (slots_.size() - 1)) {
      if (sorted(triangles[slots_[slot]]) == key) return slots_[slot];
    }
    slots_[slot] = number;
    return kNone;
  }
  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) { return 3 * triangles * sizeof(std::uint32_t); }

 private:
  static glm::uvec3 sorted(glm::uvec3 t) {
    if (t.x > t.y) std::swap(t.x, t.y);
    if (t.y > t.z) std::swap(t.y, t.z);
    if (t.x > t.y) std::swap(t.x, t.y);
    return t;
  }
  std::vector<std::uint32_t> slots_;
};

// Returns whether the triangles around a vertex are one fan, with at most two triangles at each edge.
bool is_one_fan(const mesh::VertexStar& star) {
  if (star.fans() != 1) return false;
  const std::span<const mesh::VertexStar::Side> sides = star.sides();
  std::size_t ends = 0;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].end == sides[i].end) ++end;
    if (end - i > 2 || (end - i == 2 && sides[i].outgoing == sides[i + 1].outgoing)) return false;
    ends += end - i == 1 ? 1 : 0;
    i = end;
  }
  return ends == 0 || ends == 2;
}

// Sets of vertices of one mesh that collapses merged. Union by the least number, with path halving.
class MergedVertices {
 public:
  explicit MergedVertices(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0U); }
  std::uint32_t find(std::uint32_t v) {
    while (parents_[v] != v) v = parents_[v] = parents_[parents_[v]];
    return v;
  }
  void merge(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    parents_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parents_;
};

}  // namespace

Result<LabelNet> LabelNet::join(std::span<mesh::Mesh* const> meshes, const Context& context) {
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t largest = 0;
  for (const mesh::Mesh* mesh : meshes) {
    vertices += mesh->positions.size();
    triangles += mesh->triangles.size();
    largest = std::max(largest, mesh::Adjacency::bytes(mesh->triangles.size(), mesh->positions.size()));
  }
  if (std::max(vertices, triangles) >= kNone) {
    return fail(ErrorCode::input,
                fmt::format("expected fewer than {} vertices and triangles of all labels together, found {} and {}",
                            kNone, vertices, triangles),
                {Remedy::use, Setting::parts});
  }
  const std::uint64_t kept = vertices * (sizeof(glm::vec3) + sizeof(std::uint32_t) + sizeof(VertexRole)) +
                             triangles * (sizeof(glm::uvec3) + 2 * sizeof(std::uint32_t));
  const std::uint64_t passing =
      std::max({vertices * sizeof(glm::vec3) + mesh::CoincidentVertices::bytes(vertices),
                TriangleTable::bytes(triangles), static_cast<std::uint64_t>(usable_threads()) * largest});
  auto memory = TRY(context.reserve(kept + passing, kWhat));
  try {
    LabelNet net = joined(meshes, vertices, triangles);
    memory.shrink(net.net_.positions.size_bytes() + net.net_.triangles.size_bytes() + vertices * sizeof(std::uint32_t) +
                  triangles * 2 * sizeof(std::uint32_t));
    net.memory_ = std::move(memory);
    return net;
  } catch (const std::bad_alloc&) {
    return no_memory();
  }
}

LabelNet LabelNet::joined(std::span<mesh::Mesh* const> meshes, std::size_t vertices, std::size_t triangles) {
  LabelNet net;
  net.parts_.resize(meshes.size());
  net.net_.name = "the labels";
  net.join_vertices(meshes, vertices);
  net.join_triangles(meshes, triangles);
  return net;
}

// Numbers the vertices of the net by their first occurrence.
void LabelNet::join_vertices(std::span<mesh::Mesh* const> meshes, std::size_t vertices) {
  Buffer<glm::vec3> all(vertices);
  glm::vec3* out = all.begin();
  for (const mesh::Mesh* mesh : meshes) out = std::copy(mesh->positions.begin(), mesh->positions.end(), out);
  const mesh::CoincidentVertices coincident(all.span());
  std::vector<std::uint32_t> number(vertices);
  std::vector<std::uint32_t> firsts;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    const std::uint32_t first = coincident.of_vertex(v);
    if (first == v) {
      number[v] = static_cast<std::uint32_t>(firsts.size());
      firsts.push_back(v);
    } else {
      number[v] = number[first];
    }
  }
  net_.positions = Buffer<glm::vec3>(firsts.size());
  std::ranges::transform(firsts, net_.positions.begin(), [&](std::uint32_t v) { return all[v]; });
  auto next = number.begin();
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const auto end = next + static_cast<std::ptrdiff_t>(meshes[m]->positions.size());
    parts_[m].vertices.assign(next, end);
    next = end;
  }
}

void LabelNet::join_triangles(std::span<mesh::Mesh* const> meshes, std::size_t triangles) {
  constexpr std::uint32_t kOne = kNone;  // no second label
  std::vector<glm::uvec3> net;
  std::vector<std::array<std::uint32_t, 2>> labels;
  net.reserve(triangles);
  labels.reserve(triangles);
  roles_.assign(net_.positions.size(), VertexRole::free);
  TriangleTable table(triangles);
  for (std::uint32_t m = 0; m < meshes.size(); ++m) {
    Part& part = parts_[m];
    part.triangles.reserve(meshes[m]->triangles.size());
    for (const glm::uvec3& own : meshes[m]->triangles) {
      const glm::uvec3 t(part.vertices[own.x], part.vertices[own.y], part.vertices[own.z]);
      const auto number = static_cast<std::uint32_t>(net.size());
      const std::uint32_t found = table.find_or_add(t, net, number);
      if (found != kNone && labels[found][1] == kOne && labels[found][0] != m && are_opposite(net[found], t)) {
        labels[found][1] = m;
        part.triangles.push_back(found);
        continue;
      }
      const bool is_flat = mesh::has_repeated_index(t);  // vertices of one mesh at equal positions
      if (found != kNone || is_flat) roles_[t.x] = roles_[t.y] = roles_[t.z] = VertexRole::kept;
      net.push_back(t);
      labels.push_back({m, kOne});
      part.triangles.push_back(number);
    }
  }
  net_.triangles = Buffer<glm::uvec3>(net.size());
  std::ranges::copy(net, net_.triangles.begin());
  sheet_of_.reserve(net.size());
  std::unordered_map<std::uint64_t, std::uint32_t> sheets;
  for (const auto& [first, second] : labels) {
    const auto [at, is_new] = sheets.try_emplace(std::uint64_t{first} << 32U | second, sheets_);
    sheets_ += is_new ? 1 : 0;
    sheet_of_.push_back(at->second);
  }
  for (std::size_t m = 0; m < meshes.size(); ++m) set_roles(*meshes[m], parts_[m]);
}

// Sets the role `touching` for vertices of the net that stand for several vertices of the mesh. Sets `kept` where
// several edges at one vertex of the mesh are one edge of the net, whose collapse would collapse them all.
void LabelNet::set_roles(const mesh::Mesh& mesh, const Part& part) {
  if (mesh.triangles.empty()) return;
  std::vector<glm::uvec3> placed(mesh.triangles.size());
  for (std::size_t t = 0; t < placed.size(); ++t) {
    const glm::uvec3& own = mesh.triangles[t];
    placed[t] = {part.vertices[own.x], part.vertices[own.y], part.vertices[own.z]};
  }
  const mesh::Adjacency adjacency(mesh.triangles.span(), mesh.positions.size());
  std::vector<std::uint32_t> sorted = part.vertices;
  std::ranges::sort(sorted);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    VertexRole& role = roles_[sorted[i]];
    if (sorted[i] == sorted[i - 1] && role == VertexRole::free) role = VertexRole::touching;
  }
  mesh::VertexStar star;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto corners = adjacency.corners(v);
    if (corners.empty()) continue;
    star.look_at(corners, placed);
    if (!is_one_fan(star)) roles_[part.vertices[v]] = VertexRole::kept;
  }
}

// Replaces the triangles of a mesh by the simplified ones of the net. `there` is 1 for vertices of the net that remain.
void LabelNet::take_triangles(mesh::Mesh& mesh, const Part& part, const CollapsedSheets& collapsed,
                              std::span<const char> there) const {
  // The vertex of a triangle of the mesh at a corner of the net's triangle, before all collapses.
  const auto at_corner = [&](std::size_t t, int corner) {
    const std::uint32_t vertex = net_.triangles[part.triangles[t]][corner];
    const glm::uvec3& own = mesh.triangles[t];
    return part.vertices[own.x] == vertex ? own.x : part.vertices[own.y] == vertex ? own.y : own.z;
  };
  MergedVertices merged(mesh.positions.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const MergedCorners& corners = collapsed.merged[part.triangles[t]];
    if (corners.from >= 0) merged.merge(at_corner(t, corners.from), at_corner(t, corners.to));
  }
  std::vector<std::uint32_t> left(mesh.positions.size(), kNone);  // remaining vertex of each merged set
  for (std::uint32_t v = 0; v < left.size(); ++v) {
    if (there[part.vertices[v]] != 0) left[merged.find(v)] = v;
  }
  std::vector<glm::uvec3> triangles;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!collapsed.stays(part.triangles[t])) continue;
    const glm::uvec3& own = mesh.triangles[t];
    triangles.emplace_back(left[merged.find(own.x)], left[merged.find(own.y)], left[merged.find(own.z)]);
  }
  if (triangles.size() == mesh.triangles.size()) return;
  set_triangles(mesh, triangles);
  mesh.memory.shrink(mesh.positions.size() * mesh::vertex_bytes(mesh) + mesh.triangles.size_bytes());
}

Result<SimplifyFigures> LabelNet::simplify(std::span<mesh::Mesh* const> meshes, const SimplifyOptions& options,
                                           const Context& context) const {
  const Stopwatch watch;
  SimplifyFigures facts;
  try {
    const auto collapsed =
        TRY(collapse_sheets(net_, {sheet_of_, std::max(sheets_, 1U), roles_}, options, facts, context));
    if (!collapsed.changed()) {
      facts.time = watch.elapsed();
      return facts;
    }
    constexpr std::uint64_t kVertex = 2 * sizeof(std::uint32_t);
    std::uint64_t most = 0;  // of one mesh
    for (const mesh::Mesh* mesh : meshes) {
      most = std::max(most, mesh->triangles.size_bytes() * 2 +
                                mesh->positions.size() * (kVertex + kVertex + mesh::vertex_bytes(*mesh)));
    }
    const auto memory =
        TRY(context.reserve(net_.positions.size() + static_cast<std::uint64_t>(usable_threads()) * most, kWhat));
    std::vector<char> there(net_.positions.size(), 0);
    for (std::size_t t = 0; t < collapsed.corners.size(); ++t) {
      const glm::uvec3& c = collapsed.corners[t];
      if (collapsed.stays(t)) there[c.x] = there[c.y] = there[c.z] = 1;
    }
    std::atomic<bool> failed = false;  // an exception would end the loops of other meshes in their middle
    for_each_index(meshes.size(), [&](std::size_t m) {
      try {
        take_triangles(*meshes[m], parts_[m], collapsed, there);
      } catch (const std::bad_alloc&) {
        failed = true;
      }
    });
    if (failed) return no_memory();
  } catch (const std::bad_alloc&) {
    return no_memory();
  }
  facts.time = watch.elapsed();
  return facts;
}

}  // namespace isoextract::edit

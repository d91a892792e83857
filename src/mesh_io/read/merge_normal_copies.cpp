// Merges vertices that a file duplicates for their normals. Along a crease each side has its own vertices, so that by
// the indices alone the surface is open there.
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "mesh/adjacency.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

// A boundary edge, in the direction of its triangle.
struct OpenEdge {
  std::uint32_t from;
  std::uint32_t to;
};

using Ends = std::array<float, 6>;

Ends ends_of(const mesh::Mesh& mesh, std::uint32_t from, std::uint32_t to) {
  const glm::vec3& a = mesh.positions[from];
  const glm::vec3& b = mesh.positions[to];
  return {a.x, a.y, a.z, b.x, b.y, b.z};
}

std::vector<OpenEdge> open_edges(const mesh::Mesh& mesh, MemoryUse& memory) {
  memory.take(mesh::Adjacency::bytes(mesh.triangles.size(), mesh.positions.size()));
  const mesh::Adjacency around(mesh.triangles.span(), mesh.positions.size());
  std::vector<OpenEdge> open;
  mesh::VertexStar star;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    star.look_at(around.corners(v), mesh.triangles.span());
    const auto sides = star.sides();
    for (std::size_t first = 0, last = 0; first < sides.size(); first = last) {
      while (last < sides.size() && sides[last].end == sides[first].end) ++last;
      if (last - first != 1 || !sides[first].outgoing) continue;
      memory.make_room(open, 1);
      open.push_back({v, sides[first].end});
    }
  }
  memory.give_back(mesh::Adjacency::bytes(mesh.triangles.size(), mesh.positions.size()));
  return open;
}

// Union-find over vertices: returns the first vertex of each merged group.
class Joined {
 public:
  explicit Joined(std::size_t vertices) : first_(vertices) { std::iota(first_.begin(), first_.end(), 0U); }

  std::uint32_t operator()(std::uint32_t v) {
    while (first_[v] != v) v = first_[v] = first_[first_[v]];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = (*this)(a);
    b = (*this)(b);
    first_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> first_;
};

// Returns the number of the part that a vertex belongs to; always the same number if there are no parts.
std::size_t part_of(const std::vector<MeshPart>& parts, std::uint32_t vertex) {
  const auto after = std::ranges::upper_bound(parts, std::uint64_t{vertex}, {}, &MeshPart::first_vertex);
  return static_cast<std::size_t>(after - parts.begin());
}

}  // namespace

void merge_normal_copies(mesh::Mesh& mesh, std::vector<MeshPart>& parts, const Context& context) {
  MemoryUse memory(context);
  std::vector<OpenEdge> open = open_edges(mesh, memory);
  if (open.empty()) return;
  const auto ends = [&](const OpenEdge& edge) { return ends_of(mesh, edge.from, edge.to); };
  std::ranges::stable_sort(open, {}, ends);
  memory.take(mesh.positions.size() * (2 * sizeof(std::uint32_t) + mesh::vertex_bytes(mesh)));
  Joined joined(mesh.positions.size());
  bool any = false;
  // Returns the boundary edge between two positions, or null if there is none or more than one.
  const auto only_one = [&](const Ends& at) -> const OpenEdge* {
    const auto first = std::ranges::lower_bound(open, at, {}, ends);
    const auto last = std::ranges::upper_bound(open, at, {}, ends);
    return last - first == 1 ? &*first : nullptr;
  };
  for (const OpenEdge& edge : open) {
    const OpenEdge* back = only_one(ends_of(mesh, edge.to, edge.from));
    // Several coinciding edges do not tell which of them belong together.
    if (back == nullptr || only_one(ends(edge)) == nullptr) continue;
    if (part_of(parts, edge.from) != part_of(parts, back->to)) continue;
    joined.join(edge.from, back->to);
    joined.join(edge.to, back->from);
    any = true;
  }
  if (!any) return;
  std::vector<std::uint32_t> old_of_new;
  std::vector<std::uint32_t> new_of_old(mesh.positions.size());
  for (std::uint32_t v = 0; v < new_of_old.size(); ++v) {
    if (joined(v) == v) {
      new_of_old[v] = static_cast<std::uint32_t>(old_of_new.size());
      old_of_new.push_back(v);
    } else {
      new_of_old[v] = new_of_old[joined(v)];  // joined(v) is less than v, so it is set
    }
  }
  for (glm::uvec3& t : mesh.triangles.span()) t = {new_of_old[t.x], new_of_old[t.y], new_of_old[t.z]};
  // A merged group lies within one part, so the parts stay contiguous ranges.
  for (MeshPart& part : parts) {
    const auto first = std::ranges::lower_bound(old_of_new, part.first_vertex);
    const auto last = std::ranges::lower_bound(old_of_new, part.first_vertex + part.vertices);
    part.first_vertex = static_cast<std::uint64_t>(first - old_of_new.begin());
    part.vertices = static_cast<std::uint64_t>(last - first);
  }
  mesh::gather_vertices(mesh, old_of_new);
}

}  // namespace isoextract::mesh_io

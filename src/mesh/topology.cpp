#include "mesh/topology.hpp"

#include <algorithm>
#include <new>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <tbb/parallel_sort.h>

namespace isoextract::mesh {
namespace {

// One use of an edge by a triangle: the ends in rising order, the direction of travel, and the corner it starts at.
struct EdgeUse {
  std::uint64_t ends;  // low index << 32 | high index
  std::uint64_t triangle;
  bool forward;  // from the low index to the high one
};

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t size) : parent_(size) {
    std::iota(parent_.begin(), parent_.end(), std::uint64_t{0});
  }

  std::uint64_t find(std::uint64_t element) {
    while (parent_[element] != element) {
      parent_[element] = parent_[parent_[element]];
      element = parent_[element];
    }
    return element;
  }
  void join(std::uint64_t a, std::uint64_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::uint64_t> parent_;
};

bool repeats_index(const glm::uvec3& t) { return t.x == t.y || t.y == t.z || t.z == t.x; }

std::vector<EdgeUse> sorted_edge_uses(const Mesh& mesh) {
  std::vector<EdgeUse> uses;
  uses.reserve(mesh.triangles.size() * 3);
  for (std::uint64_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3 triangle = mesh.triangles[t];
    if (repeats_index(triangle)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      const std::uint64_t a = triangle[corner];
      const std::uint64_t b = triangle[(corner + 1) % 3];
      uses.push_back({a < b ? a << 32 | b : b << 32 | a, t, a < b});
    }
  }
  tbb::parallel_sort(uses.begin(), uses.end(), [](const EdgeUse& a, const EdgeUse& b) {
    return std::pair(a.ends, a.triangle) < std::pair(b.ends, b.triangle);
  });
  return uses;
}

std::uint32_t corner_of(const glm::uvec3& triangle, std::uint32_t vertex) {
  return triangle.x == vertex ? 0 : triangle.y == vertex ? 1 : 2;
}

}  // namespace

Topology measure_topology(const Mesh& mesh) {
  Topology result;
  const std::vector<EdgeUse> uses = sorted_edge_uses(mesh);
  DisjointSets vertices(mesh.positions.size());
  // The corners (triangle, corner) around one vertex that share an edge at it belong to one fan.
  DisjointSets corners(mesh.triangles.size() * 3);

  for (std::size_t first = 0; first < uses.size();) {
    std::size_t last = first;
    while (last < uses.size() && uses[last].ends == uses[first].ends) ++last;
    const std::size_t count = last - first;
    ++result.edges;
    if (count == 1) ++result.open_edges;
    if (count > 2) ++result.nonmanifold_edges;
    if (count == 2 && uses[first].forward == uses[first + 1].forward) ++result.misoriented_edges;
    const auto low = static_cast<std::uint32_t>(uses[first].ends >> 32);
    const auto high = static_cast<std::uint32_t>(uses[first].ends);
    vertices.join(low, high);
    for (std::size_t use = first + 1; use < last; ++use) {
      const std::uint64_t t = uses[use].triangle;
      const std::uint64_t s = uses[first].triangle;
      for (const std::uint32_t vertex : {low, high}) {
        corners.join(3 * t + corner_of(mesh.triangles[t], vertex), 3 * s + corner_of(mesh.triangles[s], vertex));
      }
    }
    first = last;
  }

  std::vector<std::uint32_t> fans(mesh.positions.size(), 0);
  for (std::uint64_t t = 0; t < mesh.triangles.size(); ++t) {
    if (repeats_index(mesh.triangles[t])) {
      ++result.repeated_index_triangles;
      continue;
    }
    for (std::uint32_t corner = 0; corner < 3; ++corner) {
      if (corners.find(3 * t + corner) == 3 * t + corner) ++fans[mesh.triangles[t][static_cast<int>(corner)]];
    }
  }
  std::uint64_t used = 0;
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (fans[v] == 0) {
      ++result.unused_vertices;
      continue;
    }
    ++used;
    if (fans[v] > 1) ++result.nonmanifold_vertices;
    if (vertices.find(v) == v) ++result.components;
  }
  result.euler = static_cast<std::int64_t>(used) - static_cast<std::int64_t>(result.edges) +
                 static_cast<std::int64_t>(mesh.triangles.size() - result.repeated_index_triangles);
  return result;
}

Result<Topology> measure_topology(const Mesh& mesh, const Context& context) {
  const std::string what = mesh.name + ": the edges of its triangles";
  const std::uint64_t corners = 3 * std::uint64_t{mesh.triangles.size()};
  const auto memory = context.reserve(corners * (sizeof(EdgeUse) + sizeof(std::uint64_t)) +
                                          mesh.positions.size() * (sizeof(std::uint64_t) + sizeof(std::uint32_t)),
                                      what);
  if (!memory) return tl::unexpected(memory.error());
  try {
    return measure_topology(mesh);
  } catch (const std::bad_alloc&) {
    return fail(ErrorKind::input, what + " need more memory than there is");
  }
}

}  // namespace isoextract::mesh

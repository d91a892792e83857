#include "mesh_io/write/same_surface.hpp"

#include <algorithm>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/hash.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr int kRounds = 3;

void refine(ColouredSurface& surface) {
  std::vector<std::uint64_t> around(surface.colours.size());
  for (int round = 0; round < kRounds; ++round) {
    std::fill(around.begin(), around.end(), 0);
    for (const glm::uvec3& t : surface.triangles) {
      for (int c = 0; c < 3; ++c) {
        const std::uint64_t next = surface.colours[t[(c + 1) % 3]];
        const std::uint64_t last = surface.colours[t[(c + 2) % 3]];
        around[t[c]] += splitmix64(splitmix64(next) + last);
      }
    }
    for (std::size_t v = 0; v < around.size(); ++v) {
      surface.colours[v] = splitmix64(splitmix64(surface.colours[v]) + around[v]);
    }
  }
}

// Hashes all triangles by their colors, independent of their order and of the corner that each starts with.
std::uint64_t sum_of_triangles(const ColouredSurface& surface) {
  std::uint64_t sum = 0;
  for (const glm::uvec3& t : surface.triangles) {
    for (int c = 0; c < 3; ++c) {
      const std::uint64_t first = splitmix64(surface.colours[t[c]]);
      const std::uint64_t second = splitmix64(first + surface.colours[t[(c + 1) % 3]]);
      sum += splitmix64(second + surface.colours[t[(c + 2) % 3]]);
    }
  }
  return sum;
}

std::vector<SameVertices::Vertex> sorted(const std::vector<std::uint64_t>& colours) {
  std::vector<SameVertices::Vertex> vertices(colours.size());
  for (std::size_t v = 0; v < colours.size(); ++v) vertices[v] = {colours[v], static_cast<std::uint32_t>(v)};
  tbb::parallel_sort(vertices.begin(), vertices.end(), [](const auto& x, const auto& y) {
    return std::pair(x.colour, x.number) < std::pair(y.colour, y.number);
  });
  return vertices;
}

}  // namespace

std::size_t SameVertices::end_of_group(std::size_t first) const {
  std::size_t end = first + 1;
  while (end < a.size() && a[end].colour == a[first].colour) ++end;
  return end;
}

std::optional<SameVertices> match_vertices(ColouredSurface a, ColouredSurface b) {
  if (a.colours.size() != b.colours.size() || a.triangles.size() != b.triangles.size()) return std::nullopt;
  refine(a);
  refine(b);
  if (sum_of_triangles(a) != sum_of_triangles(b)) return std::nullopt;
  SameVertices same{sorted(a.colours), sorted(b.colours)};
  if (!std::ranges::equal(same.a, same.b, {}, &SameVertices::Vertex::colour, &SameVertices::Vertex::colour)) {
    return std::nullopt;
  }
  return same;
}

}  // namespace isoextract::mesh_io

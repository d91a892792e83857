#include "mesh_io/write/surface_match.hpp"

#include <algorithm>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/hash.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr int kRounds = 3;

void refine(ColoredSurface& surface) {
  std::vector<std::uint64_t> around(surface.colors.size());
  for (int round = 0; round < kRounds; ++round) {
    std::fill(around.begin(), around.end(), 0);
    for (const glm::uvec3& t : surface.triangles) {
      for (int c = 0; c < 3; ++c) {
        const std::uint64_t next = surface.colors[t[(c + 1) % 3]];
        const std::uint64_t last = surface.colors[t[(c + 2) % 3]];
        around[t[c]] += splitmix64(splitmix64(next) + last);
      }
    }
    for (std::size_t v = 0; v < around.size(); ++v) {
      surface.colors[v] = splitmix64(splitmix64(surface.colors[v]) + around[v]);
    }
  }
}

// Hashes all triangles by their colors, independent of their order and of the corner that each starts with.
std::uint64_t sum_of_triangles(const ColoredSurface& surface) {
  std::uint64_t sum = 0;
  for (const glm::uvec3& t : surface.triangles) {
    for (int c = 0; c < 3; ++c) {
      const std::uint64_t first = splitmix64(surface.colors[t[c]]);
      const std::uint64_t second = splitmix64(first + surface.colors[t[(c + 1) % 3]]);
      sum += splitmix64(second + surface.colors[t[(c + 2) % 3]]);
    }
  }
  return sum;
}

std::vector<VertexMatch::Vertex> sorted(const std::vector<std::uint64_t>& colors) {
  std::vector<VertexMatch::Vertex> vertices(colors.size());
  for (std::size_t v = 0; v < colors.size(); ++v) vertices[v] = {colors[v], static_cast<std::uint32_t>(v)};
  tbb::parallel_sort(vertices.begin(), vertices.end(), [](const auto& x, const auto& y) {
    return std::pair(x.color, x.number) < std::pair(y.color, y.number);
  });
  return vertices;
}

}  // namespace

std::size_t VertexMatch::end_of_group(std::size_t first) const {
  std::size_t end = first + 1;
  while (end < a.size() && a[end].color == a[first].color) ++end;
  return end;
}

std::optional<VertexMatch> match_colored_vertices(ColoredSurface a, ColoredSurface b) {
  if (a.colors.size() != b.colors.size() || a.triangles.size() != b.triangles.size()) return std::nullopt;
  refine(a);
  refine(b);
  if (sum_of_triangles(a) != sum_of_triangles(b)) return std::nullopt;
  VertexMatch same{sorted(a.colors), sorted(b.colors)};
  if (!std::ranges::equal(same.a, same.b, {}, &VertexMatch::Vertex::color, &VertexMatch::Vertex::color)) {
    return std::nullopt;
  }
  return same;
}

}  // namespace isoextract::mesh_io

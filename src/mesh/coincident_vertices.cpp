#include "mesh/coincident_vertices.hpp"

#include <tuple>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"

namespace isoextract::mesh {
namespace {

struct SortedVertex {
  glm::vec3 at;
  std::uint32_t vertex;
  [[nodiscard]] auto key() const { return std::tie(at.x, at.y, at.z, vertex); }
};

}  // namespace

CoincidentVertices::CoincidentVertices(std::span<const glm::vec3> positions) : first_(positions.size()) {
  constexpr std::size_t kVerticesAtATime = 1 << 12;
  Buffer<SortedVertex> vertices(positions.size());
  for_each_range(positions.size(), kVerticesAtATime, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v != end; ++v) {
      vertices[v] = {positions[v] + 0.0F, static_cast<std::uint32_t>(v)};  // the sum turns -0 into 0
    }
  });
  tbb::parallel_sort(vertices.begin(), vertices.end(),
                     [](const SortedVertex& a, const SortedVertex& b) { return a.key() < b.key(); });
  std::uint32_t first = 0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const bool again = i > 0 && vertices[i].at == vertices[i - 1].at;
    if (!again) first = vertices[i].vertex;
    repeated_ += again ? 1 : 0;
    first_[vertices[i].vertex] = first;
  }
}

std::uint64_t CoincidentVertices::bytes(std::uint64_t vertices) {
  return vertices * (sizeof(SortedVertex) + sizeof(std::uint32_t));
}

}  // namespace isoextract::mesh

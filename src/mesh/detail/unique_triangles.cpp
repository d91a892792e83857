#include "mesh/detail/unique_triangles.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include <tbb/parallel_sort.h>

#include "base/parallel.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::mesh {
namespace {

// The corners of a triangle, sorted.
struct CornerKey {
  glm::uvec3 places;
  std::uint32_t triangle;
  [[nodiscard]] auto key() const { return std::tie(places.x, places.y, places.z, triangle); }
};

template <class Body>
void for_each_number(std::size_t count, const Body& body) {
  constexpr std::size_t kNumbersAtATime = 1 << 12;
  for_each_range(count, kNumbersAtATime, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(i);
  });
}

glm::uvec3 sorted(glm::uvec3 t) {
  if (t.x > t.y) std::swap(t.x, t.y);
  if (t.y > t.z) std::swap(t.y, t.z);
  if (t.x > t.y) std::swap(t.x, t.y);
  return t;
}

bool has_area(std::span<const glm::vec3> positions, const glm::uvec3& t) {
  return !are_collinear(glm::dvec3(positions[t.x]), glm::dvec3(positions[t.y]), glm::dvec3(positions[t.z]));
}

}  // namespace

UniqueTriangles find_unique_triangles(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles,
                                      const CoincidentVertices& places) {
  constexpr std::uint32_t kNowhere = ~std::uint32_t{0};  // no vertex: a mesh has fewer
  Buffer<CornerKey> keys(triangles.size());
  for_each_number(triangles.size(), [&](std::size_t t) {
    const glm::uvec3 at = has_area(positions, triangles[t]) ? sorted(places.of_triangle(triangles[t]))
                                                            : glm::uvec3(kNowhere, kNowhere, kNowhere);
    keys[t] = {at, static_cast<std::uint32_t>(t)};
  });
  tbb::parallel_sort(keys.begin(), keys.end(),
                     [](const CornerKey& a, const CornerKey& b) { return a.key() < b.key(); });
  UniqueTriangles result;
  std::size_t end = keys.size();
  while (end > 0 && keys[end - 1].places.x == kNowhere) --end;
  result.zero_area = keys.size() - end;
  // Restores the order of the triangles; from here the key's first corner counts the copies.
  std::size_t distinct = 0;
  for (std::size_t i = 0; i < end;) {
    std::size_t last = i + 1;
    while (last < end && keys[last].places == keys[i].places) ++last;
    result.duplicates += last - i - 1;
    keys[distinct++] = {{static_cast<std::uint32_t>(last - i), 0, 0}, keys[i].triangle};
    i = last;
  }
  tbb::parallel_sort(keys.begin(), keys.begin() + distinct,
                     [](const CornerKey& a, const CornerKey& b) { return a.triangle < b.triangle; });
  result.triangles = Buffer<std::uint32_t>(distinct);
  result.copies = Buffer<std::uint32_t>(distinct);
  for (std::size_t i = 0; i < distinct; ++i) {
    result.triangles[i] = keys[i].triangle;
    result.copies[i] = keys[i].places.x;
  }
  return result;
}

std::uint64_t distinct_triangle_bytes(std::uint64_t triangles) {
  return triangles * (sizeof(CornerKey) + 2 * sizeof(std::uint32_t));
}

}  // namespace isoextract::mesh

#include "mesh/components.hpp"

#include "base/disjoint_sets.hpp"
#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::mesh {
namespace {

// Calls body(i) for the numbers below `count`, in parallel unless `alone`.
template <class Body>
void for_each_below(std::size_t count, bool alone, const Body& body) {
  constexpr std::size_t kGrain = 1 << 12;
  const auto in_range = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(i);
  };
  if (alone) {
    in_range(0, count);
  } else {
    for_each_range(count, kGrain, in_range);
  }
}

}  // namespace

Components::Components(std::span<const glm::uvec3> triangles, std::size_t vertices) : label_(vertices) {
  constexpr std::size_t kFewTriangles = 1 << 15;  // with fewer triangles, one thread is faster
  const bool alone = triangles.size() < kFewTriangles;
  const DisjointSets sets(label_.span(), alone);
  for_each_below(vertices, alone, [&](std::size_t v) { label_[v] = kNone; });
  const auto begin = [&](std::uint32_t v) {
    if (sets.load(v) == kNone) static_cast<void>(sets.replace(v, kNone, v));
  };
  for_each_below(triangles.size(), alone, [&](std::size_t i) {
    const glm::uvec3& t = triangles[i];
    if (has_repeated_index(t)) return;
    begin(t.x);
    begin(t.y);
    begin(t.z);
    sets.join(t.x, t.y);
    sets.join(t.x, t.z);
  });
  for_each_below(vertices, alone, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    if (sets.load(v) != kNone) sets.store(v, sets.root(v));
  });
  // Each parent, a root or not, comes earlier, so it has its number already.
  for (std::size_t v = 0; v < vertices; ++v) {
    if (label_[v] != kNone) label_[v] = label_[v] == v ? count_++ : label_[label_[v]];
  }
}

}  // namespace isoextract::mesh

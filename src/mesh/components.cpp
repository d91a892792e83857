// Disjoint sets that threads join without locks: R. J. Anderson, H. Woll: Wait-free parallel algorithms for the
// union-find problem. STOC 1991. Roots are linked by number, not by rank, so that the root of a component is its first
// vertex for any order of the threads.
#include "mesh/components.hpp"

#include <atomic>
#include <utility>

#include "base/parallel.hpp"
#include "mesh/adjacency.hpp"

namespace isoextract::mesh {
namespace {

class DisjointSets {
 public:
  // All elements are kNone at first; join() adds them.
  explicit DisjointSets(std::span<std::uint32_t> parent) : parent_(parent) {}

  void join(std::uint32_t a, std::uint32_t b) const {
    begin(a);
    begin(b);
    for (;;) {
      a = root(a);
      b = root(b);
      if (a == b) return;
      if (a < b) std::swap(a, b);
      if (replace(a, a, b)) return;  // a was still a root
    }
  }

  // Returns the first element known to be connected to `v`. Shortens the path for later calls.
  [[nodiscard]] std::uint32_t root(std::uint32_t v) const {
    std::uint32_t up = load(v);
    while (up != v) {
      const std::uint32_t next = load(up);
      // Another thread may have stored a parent nearer to the root; an older one is correct as well.
      if (next != up) store(v, next);
      v = up;
      up = next;
    }
    return v;
  }

  [[nodiscard]] std::uint32_t load(std::uint32_t v) const {
    return std::atomic_ref(parent_[v]).load(std::memory_order_relaxed);
  }
  void store(std::uint32_t v, std::uint32_t parent) const {
    std::atomic_ref(parent_[v]).store(parent, std::memory_order_relaxed);
  }

 private:
  bool replace(std::uint32_t v, std::uint32_t expected, std::uint32_t parent) const {
    return std::atomic_ref(parent_[v]).compare_exchange_strong(expected, parent, std::memory_order_relaxed);
  }
  void begin(std::uint32_t v) const {
    if (load(v) == Components::kNone) replace(v, Components::kNone, v);
  }

  std::span<std::uint32_t> parent_;
};

template <class Body>
void for_each_below(std::size_t count, const Body& body) {
  constexpr std::size_t kGrain = 1 << 12;
  for_each_range(count, kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i != end; ++i) body(i);
  });
}

}  // namespace

Components::Components(std::span<const glm::uvec3> triangles, std::size_t vertices) : label_(vertices) {
  const DisjointSets sets(label_.span());
  for_each_below(vertices, [&](std::size_t v) { label_[v] = kNone; });
  for_each_below(triangles.size(), [&](std::size_t i) {
    const glm::uvec3& t = triangles[i];
    if (has_repeated_index(t)) return;
    sets.join(t.x, t.y);
    sets.join(t.x, t.z);
  });
  for_each_below(vertices, [&](std::size_t i) {
    const auto v = static_cast<std::uint32_t>(i);
    if (sets.load(v) != kNone) sets.store(v, sets.root(v));
  });
  // A root comes first in its component, so it has its number already.
  for (std::size_t v = 0; v < vertices; ++v) {
    if (label_[v] != kNone) label_[v] = label_[v] == v ? count_++ : label_[label_[v]];
  }
}

}  // namespace isoextract::mesh

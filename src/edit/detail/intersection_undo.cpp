#include "edit/detail/intersection_undo.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {
namespace {

using ChangedTriangle = std::pair<std::uint32_t, std::uint32_t>;  // the last collapse of a triangle, the triangle

struct PresentMesh {
  mesh::Mesh mesh;
  std::vector<std::uint32_t> numbers;  // of its triangles in the state
};

Result<PresentMesh> present_mesh(const CollapseState& state, const std::string& name, const Context& context) {
  PresentMesh present;
  for (std::uint32_t t = 0; t < state.corners.size(); ++t) {
    if (state.gone[t] == 0) present.numbers.push_back(t);
  }
  present.mesh.name = name;
  present.mesh.memory = TRY(
      context.reserve(state.stored.size_bytes() + present.numbers.size() * (sizeof(glm::uvec3) + sizeof(std::uint32_t)),
                      name + ": the simplified mesh"));
  present.mesh.positions = Buffer<glm::vec3>(state.stored.size());
  std::ranges::copy(state.stored, present.mesh.positions.begin());
  present.mesh.triangles = Buffer<glm::uvec3>(present.numbers.size());
  std::ranges::transform(present.numbers, present.mesh.triangles.begin(),
                         [&](std::uint32_t t) { return state.corners[t]; });
  return present;
}

using TrianglePair = std::array<std::uint32_t, 2>;

// Returns intersecting triangles of the whole mesh.
Result<std::vector<TrianglePair>> find_pairs(const CollapseState& state, const std::string& name,
                                             const Context& context) {
  constexpr std::uint64_t kMostPairs = 1 << 20;  // at a time
  const auto present = TRY(present_mesh(state, name, context));
  auto found = TRY(mesh::find_self_intersections(present.mesh, {kMostPairs, kMostPairs}, context));
  for (TrianglePair& pair : found.examples) pair = {present.numbers[pair[0]], present.numbers[pair[1]]};
  return std::move(found.examples);
}

mesh::PlacedTriangle placed(const CollapseState& state, std::uint32_t t) {
  const glm::uvec3& c = state.corners[t];
  return {{glm::dvec3(state.stored[c.x]), glm::dvec3(state.stored[c.y]), glm::dvec3(state.stored[c.z])}};
}

mesh::FloatBox box_of(const CollapseState& state, std::uint32_t t) {
  const glm::uvec3& c = state.corners[t];
  return mesh::box_around(state.stored[c.x], state.stored[c.y], state.stored[c.z]);
}

bool has_area(const mesh::PlacedTriangle& t) {
  return !mesh::are_collinear(t.corners[0], t.corners[1], t.corners[2]);
}

bool is_copy(const mesh::PlacedTriangle& p, const mesh::PlacedTriangle& q) {
  return std::ranges::is_permutation(p.corners, q.corners);
}

// Returns intersecting triangles of which at least one is in `restored`: the pairs that find_pairs() would find.
Result<std::vector<TrianglePair>> find_pairs_of(std::span<const RestoredTriangle> restored, const CollapseState& state,
                                                const Context& context) {
  std::vector<std::uint32_t> came_back;
  for (const RestoredTriangle& r : restored) {
    if (state.gone[r.triangle] == 0) came_back.push_back(r.triangle);
  }
  std::ranges::sort(came_back);
  came_back.erase(std::unique(came_back.begin(), came_back.end()), came_back.end());
  std::erase_if(came_back, [&](std::uint32_t t) { return !has_area(placed(state, t)); });
  std::vector<TrianglePair> pairs;
  if (came_back.empty()) return pairs;
  Buffer<mesh::BoxTree::Item> items(came_back.size());
  for (std::uint32_t i = 0; i < items.size(); ++i) items[i] = {box_of(state, came_back[i]).center(), i};
  const mesh::BoxTree tree(items.span(), [&](std::uint32_t i) { return box_of(state, came_back[i]); });
  tbb::enumerable_thread_specific<std::vector<TrianglePair>> found;
  for_each_range(state.corners.size(), 1 << 10, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      if (state.gone[t] != 0) continue;
      const mesh::FloatBox box = box_of(state, t);
      tree.for_each_near(box, [&](std::uint32_t i) {
        const std::uint32_t other = came_back[i];
        if (other == t || !box.meets(box_of(state, other))) return;
        if (t < other && std::ranges::binary_search(came_back, t)) return;  // `other` finds the pair
        const mesh::PlacedTriangle p = placed(state, t);
        const mesh::PlacedTriangle q = placed(state, other);
        if (has_area(p) && mesh::find_overlap(p, q).meet && !is_copy(p, q)) found.local().push_back({t, other});
      });
    }
  });
  TRY(context.check());
  for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
  return pairs;
}

// Returns for each new pair the triangle that changed last, the latest collapse first.
std::vector<ChangedTriangle> changed_triangles(std::span<const TrianglePair> pairs, const CollapseState& state) {
  std::vector<ChangedTriangle> changed;
  for (const auto& [a, b] : pairs) {
    if (state.tangled[a] != 0 && state.tangled[b] != 0) continue;
    for (const std::uint32_t t : {a, b}) {
      const std::uint32_t other = state.changed_by[t == a ? b : a];
      const std::uint32_t own = state.changed_by[t];
      if (own != kNone && (other == kNone || own >= other)) changed.emplace_back(own, t);
    }
  }
  std::ranges::sort(changed, std::greater());
  return changed;
}

}  // namespace

Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                               std::optional<std::span<const RestoredTriangle>> restored,
                                               const std::string& name, const Context& context) {
  UndoneIntersections undone;
  std::vector<RestoredTriangle> changed;
  for (;; restored = changed) {
    const auto pairs = TRY(restored ? find_pairs_of(*restored, state, context) : find_pairs(state, name, context));
    const std::vector<ChangedTriangle> wrong = changed_triangles(pairs, state);
    if (wrong.empty()) return undone;
    changed.clear();
    for (const auto& [collapse, t] : wrong) {
      // An earlier undo may have included this one.
      if (state.changed_by[t] == collapse) undone.collapses += undo_collapse(collapse, state, logs, changed);
    }
    undone.restored.insert(undone.restored.end(), changed.begin(), changed.end());
  }
}

}  // namespace isoextract::edit

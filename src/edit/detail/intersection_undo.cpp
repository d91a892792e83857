#include "edit/detail/intersection_undo.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_invoke.h>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {
namespace {

using ChangedTriangle = std::pair<std::uint32_t, std::uint32_t>;  // the last collapse of a triangle, the triangle

using TrianglePair = std::array<std::uint32_t, 2>;
using FoundPairs = tbb::enumerable_thread_specific<std::vector<TrianglePair>>;

std::array<glm::vec3, 3> corners_of(const CollapseState& state, std::uint32_t t) {
  const glm::uvec3& c = state.corners[t];
  return {state.stored[c.x], state.stored[c.y], state.stored[c.z]};
}

mesh::PlacedTriangle placed(const CollapseState& state, std::uint32_t t) {
  const auto [a, b, c] = corners_of(state, t);
  return {{glm::dvec3(a), glm::dvec3(b), glm::dvec3(c)}};
}

mesh::FloatBox box_of(const CollapseState& state, std::uint32_t t) {
  const auto [a, b, c] = corners_of(state, t);
  return mesh::box_around(a, b, c);
}

bool has_area(const mesh::PlacedTriangle& t) { return !mesh::are_collinear(t.corners[0], t.corners[1], t.corners[2]); }

bool are_copies(const CollapseState& state, const glm::uvec3& a, const glm::uvec3& b) {
  return std::ranges::is_permutation(std::array{state.stored[a.x], state.stored[a.y], state.stored[a.z]},
                                     std::array{state.stored[b.x], state.stored[b.y], state.stored[b.z]});
}

// Returns whether two triangles intersect and a collapse may be the cause. Copies of one triangle do not count if they
// were copies at the start.
bool is_new_pair(const CollapseState& state, std::uint32_t a, std::uint32_t b) {
  if (state.tangled[a] != 0 && state.tangled[b] != 0) return false;
  if (state.changed_by[a] == kNone && state.changed_by[b] == kNone) return false;
  if (mesh::PlaneFilter(corners_of(state, a)).is_apart(mesh::CornerLanes(corners_of(state, b)))) return false;
  const mesh::PlacedTriangle p = placed(state, a);
  const mesh::PlacedTriangle q = placed(state, b);
  if (!has_area(p) || !has_area(q)) return false;
  if (are_copies(state, state.corners[a], state.corners[b])) {
    return !are_copies(state, state.start[a], state.start[b]);
  }
  return mesh::find_overlap(p, q).meet;
}

// Finds intersections with unchecked triangles, of all pairs or between different patches. The patch of an unchecked
// triangle is the one that changed it last; of any other, the one that had it in the first round since the check.
class PairsOfPatches {
 public:
  PairsOfPatches(const CollapseState& state, std::span<const CollapseLog> logs, bool skips_patches,
                 std::span<mesh::BoxTree::Item> items, const Context& context)
      : state_(state), context_(context), tree_(items, [&](std::uint32_t t) { return box_of(state, t); }) {
    boxes_ = Buffer<PatchBox>(tree_.nodes());
    tree_.fit(boxes_.span(), [&](std::uint32_t t) {
      return PatchBox{box_of(state, t), skips_patches ? patch_of(t, logs) : kSeveral, state.is_unchecked(t)};
    });
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) {
    return BoxTree::bytes(triangles) + (triangles + 1) * sizeof(PatchBox);
  }

  void find(FoundPairs& found) const { within({0, 0}, found); }

 private:
  using BoxTree = mesh::BoxTree;
  using Node = BoxTree::Node;
  static constexpr std::uint32_t kSeveral = kNone - 1;

  struct PatchBox {
    mesh::FloatBox box;
    std::uint32_t patch;
    bool is_unchecked;  // some triangle is
    [[nodiscard]] PatchBox with(const PatchBox& other) const {
      return {box.with(other.box), patch == other.patch ? patch : kSeveral, is_unchecked || other.is_unchecked};
    }
  };

  [[nodiscard]] std::uint32_t patch_of(std::uint32_t t, std::span<const CollapseLog> logs) const {
    return state_.is_unchecked(t) ? find_log(state_.changed_by[t], logs).first : state_.first_patch[t];
  }

  [[nodiscard]] const PatchBox& box(const Node& node) const { return boxes_[node.index()]; }
  [[nodiscard]] bool is_large(const Node& node) const {
    constexpr std::size_t kParallelTriangles = 1 << 11;
    return (tree_.numbers().size() >> node.level) > kParallelTriangles;
  }

  void within(const Node& node, FoundPairs& found) const {
    if (context_.cancelled() || box(node).patch != kSeveral || !box(node).is_unchecked) return;
    if (node.level == tree_.depth()) {
      const auto triangles = tree_.numbers_of(node);
      for (std::size_t i = 0; i < triangles.size(); ++i) look_at(triangles[i], triangles.subspan(i + 1), found);
      return;
    }
    const auto left = [&] { within(node.child(0), found); };
    const auto right = [&] { within(node.child(1), found); };
    const auto across = [&] { between(node.child(0), node.child(1), found); };
    if (is_large(node)) {
      tbb::parallel_invoke(left, right, across);
    } else {
      left();
      right();
      across();
    }
  }

  // Compares two nodes of one level.
  void between(const Node& a, const Node& b, FoundPairs& found) const {
    if (box(a).patch == box(b).patch && box(a).patch != kSeveral) return;
    if (!box(a).is_unchecked && !box(b).is_unchecked) return;
    if (!box(a).box.meets(box(b).box)) return;
    if (a.level == tree_.depth()) {
      for (const std::uint32_t t : tree_.numbers_of(a)) {
        if (box(b).box.meets(box_of(state_, t))) look_at(t, tree_.numbers_of(b), found);
      }
      return;
    }
    const auto part = [&](std::size_t i) { return [&, i] { between(a.child(i / 2), b.child(i % 2), found); }; };
    if (is_large(a)) {
      tbb::parallel_invoke(part(0), part(1), part(2), part(3));
    } else {
      for (std::size_t i = 0; i < 4; ++i) part(i)();
    }
  }

  void look_at(std::uint32_t t, std::span<const std::uint32_t> others, FoundPairs& found) const {
    const mesh::BoxQuery own(box_of(state_, t));
    const bool is_unchecked = state_.is_unchecked(t);
    for (const std::uint32_t other : others) {
      if (!is_unchecked && !state_.is_unchecked(other)) continue;
      if (own.meets(box_of(state_, other)) && is_new_pair(state_, t, other)) found.local().push_back({t, other});
    }
  }

  const CollapseState& state_;
  const Context& context_;
  BoxTree tree_;
  Buffer<PatchBox> boxes_;  // by node
};

std::vector<TrianglePair> joined(const FoundPairs& found) {
  std::vector<TrianglePair> pairs;
  for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
  return pairs;
}

Result<std::vector<TrianglePair>> find_pairs_of_patches(const CollapseState& state, std::span<const CollapseLog> logs,
                                                        bool skips_patches, const std::string& name,
                                                        const Context& context) {
  const auto triangles = static_cast<std::size_t>(std::ranges::count(state.gone, 0));
  const auto memory = TRY(context.reserve(intersection_search_bytes(triangles),
                                          name + ": the search for intersections of the simplified mesh"));
  Buffer<mesh::BoxTree::Item> items(triangles);
  std::size_t count = 0;
  for (std::uint32_t t = 0; t < state.corners.size(); ++t) {
    if (state.gone[t] == 0) items[count++] = {box_of(state, t).center(), t};
  }
  FoundPairs found;
  PairsOfPatches(state, logs, skips_patches, items.span(), context).find(found);
  TRY(context.check());
  return joined(found);
}

// Finds new pairs of which at least one triangle is in `restored`.
Result<std::vector<TrianglePair>> find_pairs_of(std::span<const RestoredTriangle> restored, const CollapseState& state,
                                                const Context& context) {
  std::vector<std::uint32_t> came_back;
  for (const RestoredTriangle& r : restored) {
    if (state.gone[r.triangle] == 0) came_back.push_back(r.triangle);
  }
  std::ranges::sort(came_back);
  came_back.erase(std::unique(came_back.begin(), came_back.end()), came_back.end());
  if (came_back.empty()) return std::vector<TrianglePair>();
  Buffer<mesh::BoxTree::Item> items(came_back.size());
  for (std::uint32_t i = 0; i < items.size(); ++i) items[i] = {box_of(state, came_back[i]).center(), i};
  const mesh::BoxTree tree(items.span(), [&](std::uint32_t i) { return box_of(state, came_back[i]); });
  FoundPairs found;
  for_each_range(state.corners.size(), 1 << 10, [&](std::size_t begin, std::size_t end) {
    if (context.cancelled()) return;
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      if (state.gone[t] != 0) continue;
      const mesh::FloatBox box = box_of(state, t);
      tree.for_each_near(box, [&](std::uint32_t i) {
        const std::uint32_t other = came_back[i];
        if (other == t || !box.meets(box_of(state, other))) return;
        if (t < other && std::ranges::binary_search(came_back, t)) return;  // `other` finds the pair
        if (is_new_pair(state, t, other)) found.local().push_back({t, other});
      });
    }
  });
  TRY(context.check());
  return joined(found);
}

// Returns for each new pair the triangle that changed last, the latest collapse first.
std::vector<ChangedTriangle> changed_triangles(std::span<const TrianglePair> pairs, const CollapseState& state) {
  std::vector<ChangedTriangle> changed;
  for (const auto& [a, b] : pairs) {
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

std::uint64_t intersection_search_bytes(std::uint64_t triangles) {
  return triangles * sizeof(mesh::BoxTree::Item) + PairsOfPatches::bytes(triangles);
}

Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                               std::span<const RestoredTriangle> restored, UnlikelyPairs skipped,
                                               const std::string& name, const Context& context) {
  UndoneIntersections undone;
  std::vector<TrianglePair> pairs;
  if (skipped != UnlikelyPairs::not_restored) {
    pairs = TRY(find_pairs_of_patches(state, logs, skipped == UnlikelyPairs::of_one_patch, name, context));
  }
  std::vector<RestoredTriangle> changed(restored.begin(), restored.end());
  for (;;) {
    const auto of_restored = TRY(find_pairs_of(changed, state, context));
    pairs.insert(pairs.end(), of_restored.begin(), of_restored.end());
    const std::vector<ChangedTriangle> wrong = changed_triangles(pairs, state);
    if (wrong.empty()) return undone;
    pairs.clear();
    changed.clear();
    for (const auto& [collapse, t] : wrong) {
      // An earlier undo may have included this one.
      if (state.changed_by[t] == collapse) undone.collapses += undo_collapse(collapse, state, logs, changed);
    }
    undone.restored.insert(undone.restored.end(), changed.begin(), changed.end());
  }
}

}  // namespace isoextract::edit

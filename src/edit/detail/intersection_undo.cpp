#include "edit/detail/intersection_undo.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_invoke.h>

#include "base/buffer.hpp"
#include "base/parallel.hpp"
#include "edit/detail/near_triangles.hpp"
#include "edit/detail/patch_triangles.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/exact_sign.hpp"
#include "mesh/triangle_overlap.hpp"

namespace isoextract::edit {
namespace {

using ChangedTriangle = std::pair<std::uint32_t, std::uint32_t>;  // the last collapse of a triangle, the triangle

using TrianglePair = std::array<std::uint32_t, 2>;

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
  if (mesh::PlaneFilter(corners_of(state, b)).is_apart(mesh::CornerLanes(corners_of(state, a)))) return false;
  const mesh::PlacedTriangle p = placed(state, a);
  const mesh::PlacedTriangle q = placed(state, b);
  if (!has_area(p) || !has_area(q)) return false;
  if (are_copies(state, state.corners[a], state.corners[b])) {
    return !are_copies(state, state.start[a], state.start[b]);
  }
  return mesh::find_overlap(p, q).meet;
}

// Collects pairs for the log of the later one of the two last collapses: the one to undo. If logs can be undone as a
// whole, drops the pairs of those with too many, which limits the memory. Several threads may add pairs.
class FoundPairs {
 public:
  FoundPairs(const CollapseState& state, std::span<const CollapseLog> logs, bool undoes_logs)
      : state_(state), logs_(logs), counts_(undoes_logs ? logs.size() : 0, 0) {}

  // Adds the pair if it is new.
  void look_at(std::uint32_t a, std::uint32_t b) {
    const std::uint32_t collapse = last_collapse(a, b);
    if (collapse == kNone) return;
    if (counts_.empty()) {
      if (is_new_pair(state_, a, b)) pairs_.local().push_back({a, b});
      return;
    }
    if (!is_new_pair(state_, a, b)) return;
    const std::size_t log = log_of(collapse);
    const std::atomic_ref count(counts_[log]);
    if (count.load(std::memory_order_relaxed) > most_pairs(log)) return;
    if (count.fetch_add(1, std::memory_order_relaxed) < most_pairs(log)) pairs_.local().push_back({a, b});
  }

  // Returns the logs with too many pairs since the start, and forgets these pairs.
  [[nodiscard]] std::vector<std::size_t> take_crowded_logs() {
    std::vector<std::size_t> crowded;
    for (std::size_t log = 0; log < counts_.size(); ++log) {
      if (counts_[log] > most_pairs(log)) crowded.push_back(log);
    }
    for (auto& pairs : pairs_) {
      if (crowded.empty()) break;
      std::erase_if(pairs, [&](const TrianglePair& pair) {
        const std::size_t log = log_of(last_collapse(pair[0], pair[1]));
        return counts_[log] > most_pairs(log);
      });
    }
    for (const std::size_t log : crowded) counts_[log] = 0;
    return crowded;
  }

  // Makes any pair found from now on one too many for its log.
  void allow_no_pairs() {
    allows_pairs_ = false;
    std::ranges::fill(counts_, 0);
  }

  // Returns for each pair the triangle that changed last, the latest collapse first. Forgets the pairs.
  [[nodiscard]] std::vector<ChangedTriangle> take_changed_triangles() {
    std::vector<ChangedTriangle> changed;
    for (auto& pairs : pairs_) {
      for (const auto& [a, b] : pairs) {
        const std::uint32_t collapse = last_collapse(a, b);
        for (const std::uint32_t t : {a, b}) {
          if (state_.changed_by[t] == collapse) changed.emplace_back(collapse, t);
        }
      }
      pairs = {};
    }
    std::ranges::sort(changed, std::greater());
    return changed;
  }

 private:
  // Returns kNone if no collapse has changed the triangles.
  [[nodiscard]] std::uint32_t last_collapse(std::uint32_t a, std::uint32_t b) const {
    const std::uint32_t of_a = state_.changed_by[a];
    const std::uint32_t of_b = state_.changed_by[b];
    if (of_a == kNone || of_b == kNone) return std::min(of_a, of_b);
    return std::max(of_a, of_b);
  }
  [[nodiscard]] std::size_t log_of(std::uint32_t collapse) const {
    return static_cast<std::size_t>(&find_log(collapse, logs_) - logs_.data());
  }
  [[nodiscard]] std::uint32_t most_pairs(std::size_t log) const {
    constexpr std::uint32_t kFew = 50;
    constexpr std::uint32_t kRemovedOfPair = 100;
    return allows_pairs_ ? std::max(kFew, logs_[log].removed / kRemovedOfPair) : 0;
  }

  const CollapseState& state_;
  std::span<const CollapseLog> logs_;
  std::vector<std::uint32_t> counts_;  // pairs of each log, or more than most_pairs(); empty: logs stay
  bool allows_pairs_ = true;
  tbb::enumerable_thread_specific<std::vector<TrianglePair>> pairs_;
};

// A triangle with what the search for intersections often needs of it, in one place.
struct SearchedTriangle {
  std::array<glm::vec3, 3> corners;
  std::uint32_t number;
  bool is_unchecked;

  [[nodiscard]] mesh::FloatBox box() const { return mesh::box_around(corners[0], corners[1], corners[2]); }
};

// Returns the patch of a triangle: of an unchecked one, the patch that changed it last; of any other, the patch that
// had it in the first round since the check.
std::uint32_t patch_of(const CollapseState& state, std::uint32_t t, std::span<const CollapseLog> logs) {
  return state.is_unchecked(t) ? find_log(state.changed_by[t], logs).first : state.first_patch[t];
}

// Finds intersections with unchecked triangles, of all pairs or between different patches.
class PairsOfPatches {
 public:
  // The numbers of `items` are indices into `triangles`.
  PairsOfPatches(const CollapseState& state, std::span<const CollapseLog> logs, bool skips_patches,
                 std::span<const SearchedTriangle> triangles, std::span<mesh::BoxTree::Item> items,
                 const Context& context)
      : context_(context), triangles_(triangles), tree_(items, [&](std::uint32_t i) { return triangles[i].box(); }) {
    patches_ = Buffer<Patch>(tree_.nodes());
    tree_.fit(patches_.span(), [&](std::uint32_t i) {
      const SearchedTriangle& t = triangles[i];
      return Patch{skips_patches ? patch_of(state, t.number, logs) : kSeveral, t.is_unchecked};
    });
  }

  [[nodiscard]] static std::uint64_t bytes(std::uint64_t triangles) {
    return BoxTree::bytes(triangles) + triangles * sizeof(SearchedTriangle) + (triangles + 1) * sizeof(Patch);
  }

  void find(FoundPairs& found) const { within({0, 0}, found); }

 private:
  using BoxTree = mesh::BoxTree;
  using Node = BoxTree::Node;
  static constexpr std::uint32_t kSeveral = kNone - 1;

  // The patch of all triangles below a node.
  struct Patch {
    std::uint32_t number;
    bool is_unchecked;  // a triangle is unchecked
    [[nodiscard]] Patch with(const Patch& other) const {
      return {number == other.number ? number : kSeveral, is_unchecked || other.is_unchecked};
    }
  };

  [[nodiscard]] const Patch& patch(const Node& node) const { return patches_[node.index()]; }
  [[nodiscard]] const mesh::FloatBox& box(const Node& node) const { return tree_.box(node.index()); }
  [[nodiscard]] bool is_large(const Node& node) const {
    constexpr std::size_t kParallelTriangles = 1 << 11;
    return (tree_.numbers().size() >> node.level) > kParallelTriangles;
  }

  void within(const Node& node, FoundPairs& found) const {
    if (context_.cancelled() || patch(node).number != kSeveral || !patch(node).is_unchecked) return;
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
    if (patch(a).number == patch(b).number && patch(a).number != kSeveral) return;
    if (!patch(a).is_unchecked && !patch(b).is_unchecked) return;
    if (!box(a).meets(box(b))) return;
    if (a.level == tree_.depth()) {
      for (const std::uint32_t t : tree_.numbers_of(a)) {
        if (box(b).meets(triangles_[t].box())) look_at(t, tree_.numbers_of(b), found);
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

  void look_at(std::uint32_t i, std::span<const std::uint32_t> others, FoundPairs& found) const {
    const SearchedTriangle& t = triangles_[i];
    const mesh::BoxQuery box(t.box());
    std::optional<mesh::PlaneFilter> plane;
    for (const std::uint32_t j : others) {
      const SearchedTriangle& other = triangles_[j];
      if (!(t.is_unchecked || other.is_unchecked) || !box.meets_triangle(other.corners.data())) continue;
      if (!plane) plane.emplace(t.corners);
      if (!plane->is_apart(mesh::CornerLanes(other.corners))) found.look_at(t.number, other.number);
    }
  }

  const Context& context_;
  std::span<const SearchedTriangle> triangles_;
  BoxTree tree_;
  Buffer<Patch> patches_;  // by node
};

// Finds new pairs of which at least one triangle is in `listed`, in ascending order and without duplicates.
// skips(t, i) tells whether not to look at the pair of t and listed[i].
template <class Skips>
Result<void> find_pairs_of(std::span<const std::uint32_t> listed, const CollapseState& state, const std::string& name,
                           const Context& context, const Skips& skips, FoundPairs& found) {
  if (listed.empty()) return {};
  const auto memory = TRY(context.reserve(intersection_search_bytes(listed.size()),
                                          name + ": the search for intersections of changed triangles"));
  const auto box = [&](std::uint32_t t) { return box_of(state, t); };
  Buffer<mesh::BoxTree::Item> items(listed.size());
  for (std::uint32_t i = 0; i < items.size(); ++i) items[i] = {box(listed[i]).center(), i};
  const mesh::BoxTree tree(items.span(), [&](std::uint32_t i) { return box(listed[i]); });
  using Nodes = std::span<const mesh::BoxTree::Node>;
  for_each_triangle_near(tree, state, box, context, [&](std::uint32_t t, const mesh::FloatBox& of_t, Nodes nodes) {
    const auto look_at = [&](std::uint32_t i) {
      const std::uint32_t other = listed[i];
      if (other == t || !of_t.meets(box(other))) return;
      if (t < other && std::ranges::binary_search(listed, t)) return;  // `other` finds the pair
      if (!skips(t, i)) found.look_at(t, other);
    };
    tree.for_each_near(of_t, look_at, nodes);
  });
  return context.check();
}

// Finds new pairs of which at least one triangle was restored.
Result<void> find_pairs_of_restored(std::span<const RestoredTriangle> restored, const CollapseState& state,
                                    const std::string& name, const Context& context, FoundPairs& found) {
  std::vector<std::uint32_t> came_back;
  for (const RestoredTriangle& r : restored) {
    if (state.gone[r.triangle] == 0) came_back.push_back(r.triangle);
  }
  std::ranges::sort(came_back);
  came_back.erase(std::unique(came_back.begin(), came_back.end()), came_back.end());
  return find_pairs_of(
      came_back, state, name, context, [](std::uint32_t, std::uint32_t) { return false; }, found);
}

// Finds new pairs of which at least one triangle is unchecked.
Result<void> find_unchecked_pairs(const CollapseState& state, std::span<const CollapseLog> logs, bool skips_patches,
                                  const std::string& name, const Context& context, FoundPairs& found) {
  constexpr std::size_t kFew = 16;  // of so many triangles, one is unchecked
  std::vector<PatchTriangle> remaining = remaining_triangles(state, [](const glm::uvec3& /*corners*/) { return true; });
  const std::size_t triangles = remaining.size();
  std::vector<std::uint32_t> unchecked;
  for (const PatchTriangle& listed : remaining) {
    if (!state.is_unchecked(listed.triangle)) continue;
    if (unchecked.size() > triangles / kFew) break;
    unchecked.push_back(listed.triangle);
  }
  if (unchecked.size() <= triangles / kFew) {
    std::vector<std::uint32_t> patches;
    for (const std::uint32_t t : unchecked) patches.push_back(skips_patches ? patch_of(state, t, logs) : 0);
    const auto skips = [&](std::uint32_t t, std::uint32_t i) {
      return skips_patches && patch_of(state, t, logs) == patches[i];
    };
    // Many triangles at one vertex would have very many pairs.
    const auto is_in_patch_of_first = [&](const PatchTriangle& listed) { return skips(listed.triangle, 0); };
    if (unchecked.empty() || std::ranges::all_of(remaining, is_in_patch_of_first)) return {};
    return find_pairs_of(unchecked, state, name, context, skips, found);
  }
  const auto memory = TRY(context.reserve(intersection_search_bytes(triangles),
                                          name + ": the search for intersections of the simplified mesh"));
  Buffer<SearchedTriangle> searched(triangles);
  Buffer<mesh::BoxTree::Item> items(triangles);
  const auto add = [&](std::uint32_t i) {
    const std::uint32_t t = remaining[i].triangle;
    searched[i] = {corners_of(state, t), t, state.is_unchecked(t)};
    items[i] = {searched[i].box().center(), i};
  };
  for_each_index(static_cast<std::uint32_t>(triangles), add, kTriangleGrain);
  remaining = {};
  PairsOfPatches(state, logs, skips_patches, searched.span(), items.span(), context).find(found);
  return context.check();
}

// Undoes all collapses of a log, and all that depend on them. Lists each changed triangle once in `changed`. Returns
// the number of undone collapses.
std::size_t undo_log(const CollapseLog& log, CollapseState& state, std::span<const CollapseLog> logs,
                     std::vector<RestoredTriangle>& changed) {
  std::vector<RestoredTriangle> steps;
  std::size_t count = 0;
  for (const CollapseLog::Record& record : log.records) {
    const std::uint32_t& last = state.changed_by[record.triangle];
    while (last != kNone && last >= log.first) count += undo_collapse(last, state, logs, steps);
  }
  std::ranges::stable_sort(steps, {}, &RestoredTriangle::triangle);
  const auto end = std::unique(steps.begin(), steps.end(), [](const RestoredTriangle& a, const RestoredTriangle& b) {
    return a.triangle == b.triangle;
  });
  changed.insert(changed.end(), steps.begin(), end);
  return count;
}

}  // namespace

std::uint64_t intersection_search_bytes(std::uint64_t triangles) {
  return triangles * sizeof(mesh::BoxTree::Item) + PairsOfPatches::bytes(triangles);
}

Result<UndoneIntersections> undo_intersections(CollapseState& state, std::span<const CollapseLog> logs,
                                               std::span<const RestoredTriangle> restored, SkippedPairs skipped,
                                               const std::string& name, const Context& context) {
  constexpr int kMostPasses = 8;  // each looks at all triangles; later ones undo patches as a whole
  UndoneIntersections undone;
  FoundPairs found(state, logs, skipped == SkippedPairs::none);
  if (skipped != SkippedPairs::without_restored_triangle) {
    TRY(find_unchecked_pairs(state, logs, skipped == SkippedPairs::within_a_patch, name, context, found));
  }
  std::vector<RestoredTriangle> changed(restored.begin(), restored.end());
  for (int pass = 1;; ++pass) {
    TRY(find_pairs_of_restored(changed, state, name, context, found));
    const std::vector<std::size_t> crowded = found.take_crowded_logs();
    const std::vector<ChangedTriangle> wrong = found.take_changed_triangles();
    if (crowded.empty() && wrong.empty()) return undone;
    changed.clear();
    for (const std::size_t log : crowded) undone.collapses += undo_log(logs[log], state, logs, changed);
    for (const auto& [collapse, t] : wrong) {
      // An earlier undo may have included this one.
      if (state.changed_by[t] == collapse) undone.collapses += undo_collapse(collapse, state, logs, changed);
    }
    if (pass == kMostPasses) found.allow_no_pairs();
    undone.patches += crowded.size();
    undone.restored.insert(undone.restored.end(), changed.begin(), changed.end());
  }
}

}  // namespace isoextract::edit

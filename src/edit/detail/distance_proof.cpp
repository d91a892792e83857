#include "edit/detail/distance_proof.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "base/parallel.hpp"
#include "edit/detail/near_triangles.hpp"
#include "mesh/box_tree.hpp"
#include "mesh/distance_bound.hpp"
#include "mesh/metrics.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {
namespace {

constexpr std::size_t kProofGrain = 256;
constexpr std::size_t kSheetGrain = 64;

class DistanceProof {
 public:
  DistanceProof(CollapseState& state, std::span<const CollapseLog> logs, const DistanceProofOptions& options,
                ProvenDistances& proven, const Context& context)
      : state_(state), logs_(logs), options_(options), context_(context), proven_(proven) {
    limits_.tolerance = 0;
    limits_.enough = options.enough;
    limits_.refuse = options.enough;
    limits_.floor = 1e-3 * options.enough;  // closer to the limit than this: reject
  }

  Result<Proof> run() {
    Proof proof;
    std::vector<std::uint32_t> new_in_doubt;
    std::vector<std::uint32_t> old_in_doubt;
    covers_all_ = proven_.original.empty();
    if (covers_all_) {
      proven_.original.resize(state_.corners.size());
      new_in_doubt.resize(state_.corners.size());
      std::iota(new_in_doubt.begin(), new_in_doubt.end(), 0U);
      old_in_doubt = state_.has_past() ? originals_near_changes() : new_in_doubt;
    } else {
      find_doubts(proven_.restored, new_in_doubt, old_in_doubt);
    }
    proven_.restored.clear();
    for (;; covers_all_ = false) {
      TRY(context_.check());
      ++proof.passes;
      context_.progress().begin("measuring the simplified mesh", new_in_doubt.size() + old_in_doubt.size());
      const std::vector<std::uint32_t> wrong = measure(new_in_doubt, old_in_doubt);
      if (context_.cancelled()) continue;
      if (wrong.empty()) break;
      std::vector<RestoredTriangle> changed;
      std::vector<std::uint32_t> of_past;  // an undone collapse leaves others of the list without one
      for (const std::uint32_t t : wrong) {
        if (state_.has_past() && state_.changed_by[t] == kNone) of_past.push_back(t);
      }
      for (const std::uint32_t t : wrong) {
        if (state_.changed_by[t] == kNone) continue;
        if (options_.once) proof.refused.push_back(find_collapse(state_.changed_by[t], logs_).vertex);
        proof.undone += undo_collapse(state_.changed_by[t], state_, logs_, changed);
      }
      for (const std::uint32_t t : of_past) proof.undone += undo_near(t, changed);
      proven_.restored.insert(proven_.restored.end(), changed.begin(), changed.end());
      if (options_.once) break;
      find_doubts(changed, new_in_doubt, old_in_doubt);
    }
    const std::vector<DistanceBounds>& original = proven_.original;
    for (std::uint32_t t = 0; t < original.size(); ++t) {
      const DistanceBounds now =
          state_.gone[t] == 0 && state_.changed_by[t] != kNone ? state_.known[t] : DistanceBounds();
      proof.lower = std::max({proof.lower, now.lower, original[t].lower});
      proof.upper = std::max({proof.upper, now.upper, original[t].upper});
    }
    return proof;
  }

 private:
  // Measures the triangles in doubt. Returns the triangles that are too far away; for an original one, the nearest
  // remaining triangle instead if a collapse changed it.
  std::vector<std::uint32_t> measure(const std::vector<std::uint32_t>& new_in_doubt,
                                     const std::vector<std::uint32_t>& old_in_doubt) {
    std::vector<std::uint32_t> wrong(new_in_doubt.size() + old_in_doubt.size(), kNone);
    for_each_in_doubt(new_in_doubt, [&](std::size_t i, std::uint32_t t) {
      if (state_.gone[t] != 0) return;
      if (state_.changed_by[t] == kNone || state_.known[t].is_known()) return;
      const mesh::TriangleBound found = bound(state_.corners[t], state_.original_tree(t), state_.original_cover,
                                              state_.sheet(t), std::array{state_.original_slot[t]});
      state_.known[t] = {found.lower, found.upper};
      if (!good(found)) wrong[i] = t;
    });
    if (context_.cancelled()) return {};
    // Later passes use only triangles near changes: other triangles could only lower the distance.
    const std::vector<char> left_out = covers_all_ ? state_.gone : far_from_changes();
    const SheetTrees trees(state_.positions, state_.corners, left_out, state_.sheets);
    const std::vector<std::uint32_t> slots = trees.slots(left_out.size());
    const SurfaceCover cover(trees, slots, state_.corners, state_.positions.size(), left_out, state_.sheets);
    std::vector<std::uint32_t> near(state_.positions.size(), kNone);  // a triangle near each vertex, if known
    for (std::uint32_t t = 0; t < left_out.size(); ++t) {
      if (left_out[t] != 0) continue;
      for (int corner = 0; corner < 3; ++corner) near[state_.corners[t][corner]] = t;
      for (std::uint32_t s = state_.first_sample[t]; s != kNone; s = state_.next_sample[s]) near[s] = t;
    }
    for_each_in_doubt(old_in_doubt, [&](std::size_t i, std::uint32_t t) {
      const std::uint32_t sheet = state_.sheet(t);
      const mesh::TriangleTree* const tree = trees.find(sheet);
      if (tree == nullptr) return;  // nothing of the sheet has changed near it
      proven_.original[t] = {};
      if (state_.is_original(t)) return;
      const glm::uvec3& c = state_.original[t];
      std::array<std::uint32_t, 3> near_slots{};
      std::size_t count = 0;
      for (const std::uint32_t v : {c.x, c.y, c.z}) {
        if (near[v] != kNone && state_.sheet(near[v]) == sheet) near_slots[count++] = slots[near[v]];
      }
      if (count == 0) count = 1;  // any slot will do
      const mesh::TriangleBound found = bound(c, *tree, cover, sheet, std::span(near_slots.data(), count));
      // Other parts of the mesh, and later collapses in this one, may still come nearer.
      const bool is_final = covers_all_ && !state_.has_past();
      proven_.original[t] = {is_final ? found.lower : 0, found.upper};
      if (good(found)) return;
      const auto& [a, b, d] = corners(c);
      const std::uint32_t nearest = trees.triangle(sheet, tree->nearest((a + b + d) / 3.0, near_slots.front()).slot);
      wrong[new_in_doubt.size() + i] = state_.changed_by[nearest] == kNone ? t : nearest;
    });
    std::erase(wrong, kNone);
    return wrong;
  }

  template <class Body>
  void for_each_in_doubt(const std::vector<std::uint32_t>& triangles, const Body& body) {
    for_each_fixed_range(triangles.size(), kProofGrain, [&](std::size_t begin, std::size_t end) {
      if (context_.cancelled()) return;
      for (std::size_t i = begin; i < end; ++i) body(i, triangles[i]);
      context_.progress().advance(end - begin);
    });
  }

  // Bounds the distance from t to the tree. Rejects a triangle that needs far more parts than there are original
  // triangles under it: it is close to the limit. The tree and the cover are those of `sheet`; `near` holds slots of
  // the tree that may be near t.
  [[nodiscard]] mesh::TriangleBound bound(const glm::uvec3& t, const mesh::TriangleTree& tree,
                                          const SurfaceCover& cover, std::uint32_t sheet,
                                          std::span<const std::uint32_t> near) const {
    const auto places = corners(t);
    const double enough_squared = limits_.enough * limits_.enough;
    std::array<std::uint32_t, 3> slots{};  // without duplicates
    std::size_t count = 0;
    for (const std::uint32_t slot : near) {
      if (std::find(slots.begin(), slots.begin() + count, slot) != slots.begin() + count) continue;
      slots[count++] = slot;
      const double farthest = tree.max_distance_squared(slot, places, enough_squared);
      if (farthest > enough_squared) continue;
      mesh::TriangleBound found;
      found.upper = std::sqrt(farthest);
      found.slot = slot;
      return found;
    }
    const auto covered = cover.bound(places, tree, sheet, slots.front(), limits_.enough);
    if (covered) return *covered;
    mesh::DistanceLimits limits = limits_;
    const double cells = glm::length(glm::cross(places[1] - places[0], places[2] - places[0])) /
                         (options_.original_size * options_.original_size);
    limits.max_parts = 256 + static_cast<std::size_t>(std::min(64 * cells, 1e7));
    return mesh::bound_distance(places, tree, limits, 0, slots.front(), {slots.data(), count});
  }

  [[nodiscard]] bool good(const mesh::TriangleBound& bound) const { return bound.upper <= options_.enough; }

  [[nodiscard]] std::array<glm::dvec3, 3> corners(const glm::uvec3& t) const {
    return {state_.positions[t.x], state_.positions[t.y], state_.positions[t.z]};
  }

  // Returns 0 for each remaining triangle that may be the nearest of an original one in doubt, else 1.
  [[nodiscard]] std::vector<char> far_from_changes() const {
    std::vector<char> is_far(state_.corners.size(), 1);
    if (!changes_) return is_far;
    const auto box_of = [&](std::uint32_t t) {
      const glm::uvec3& c = state_.corners[t];
      return mesh::box_around(state_.positions[c.x], state_.positions[c.y], state_.positions[c.z]);
    };
    using Nodes = std::span<const mesh::BoxTree::Node>;
    for_each_triangle_near(*changes_, state_, box_of, context_,
                           [&](std::uint32_t t, const mesh::FloatBox& box, Nodes nodes) {
                             if (changes_->any_leaf_near(box, nodes)) is_far[t] = 0;
                           });
    return is_far;
  }

  // Returns 1 or 0 for each triangle: whether `holds`.
  template <class Predicate>
  [[nodiscard]] std::vector<char> marked(const Predicate& holds) const {
    std::vector<char> marks(state_.original.size(), 0);
    for_each_range(marks.size(), kProofGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) {
        marks[t] = holds(static_cast<std::uint32_t>(t)) ? 1 : 0;
      }
    });
    return marks;
  }

  struct Box {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};

    void add(const Box& other) {
      low = glm::min(low, other.low);
      high = glm::max(high, other.high);
    }
    [[nodiscard]] bool is_within(double distance, const Box& other) const {
      return glm::all(glm::lessThanEqual(low - other.high, glm::dvec3(distance))) &&
             glm::all(glm::lessThanEqual(other.low - high, glm::dvec3(distance)));
    }
  };
  [[nodiscard]] Box box_of(const glm::uvec3& t) const {
    const auto [a, b, c] = corners(t);
    return {glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))};
  }

  // Returns the box around a triangle, enlarged by `gap` and by rounding.
  [[nodiscard]] mesh::FloatBox float_box(const glm::uvec3& t, double gap) const {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const Box around = box_of(t);
    const glm::vec3 low(around.low - gap);
    const glm::vec3 high(around.high + gap);
    mesh::FloatBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.min[axis] = std::nextafter(low[axis], -kInfinity);
      box.max[axis] = std::nextafter(high[axis], kInfinity);
    }
    return box;
  }

  // Returns whether the triangle was there at the start, and has changed since.
  [[nodiscard]] bool has_changed(std::uint32_t t) const {
    return state_.changed_by[t] != kNone && state_.gone_at_start[t] == 0;
  }

  // Lists the original triangles that may have been nearest to triangles before they changed. The distances of all
  // others hold since before the start.
  [[nodiscard]] std::vector<std::uint32_t> originals_near_changes() const {
    Box changes;
    for (std::uint32_t t = 0; t < state_.start.size(); ++t) {
      if (has_changed(t)) changes.add(box_of(state_.start[t]));
    }
    return listed([&](std::uint32_t t) { return changes.is_within(options_.enough, box_of(state_.original[t])); });
  }

  // Undoes all collapses near an original triangle that is too far from the mesh, although its own last collapse is in
  // the past. Without them the triangle is as near as before the start. Returns the number of undone collapses.
  std::size_t undo_near(std::uint32_t original, std::vector<RestoredTriangle>& changed) {
    const Box around = box_of(state_.original[original]);
    std::size_t undone = 0;
    for (std::uint32_t t = 0; t < state_.start.size(); ++t) {
      if (!has_changed(t) || !around.is_within(options_.enough, box_of(state_.start[t]))) continue;
      // A triangle may have changed several times.
      while (state_.changed_by[t] != kNone) undone += undo_collapse(state_.changed_by[t], state_, logs_, changed);
    }
    proven_.original[original] = {0, 0};  // its bound is part of the proof before the start
    return undone;
  }

  // Lists the restored triangles, and the original triangles near the collapsed forms that they replace.
  void find_doubts(const std::vector<RestoredTriangle>& changed, std::vector<std::uint32_t>& new_in_doubt,
                   std::vector<std::uint32_t>& old_in_doubt) {
    new_in_doubt.clear();
    // An original in doubt is within `enough` of a change, and so should its nearest triangle be of it. The original
    // itself may be wide.
    const double gap = 2 * (options_.enough + options_.original_size);
    std::vector<mesh::FloatBox> boxes;
    std::vector<mesh::BoxTree::Item> items;
    for (const RestoredTriangle& put_back : changed) {
      new_in_doubt.push_back(put_back.triangle);
      for (const glm::uvec3& form : {put_back.corners, state_.corners[put_back.triangle]}) {
        const Box around = box_of(form);  // the center of an enlarged one may be infinite
        items.push_back({glm::vec3(0.5 * (around.low + around.high)), static_cast<std::uint32_t>(boxes.size())});
        boxes.push_back(float_box(form, gap));
      }
    }
    std::sort(new_in_doubt.begin(), new_in_doubt.end());
    new_in_doubt.erase(std::unique(new_in_doubt.begin(), new_in_doubt.end()), new_in_doubt.end());
    changes_.reset();
    if (!items.empty()) changes_.emplace(items, [&](std::uint32_t i) { return boxes[i]; });
    old_in_doubt = originals_near(changed);
  }

  // Lists the original triangles whose bounds may not hold after triangles were restored. Upper bounds may be those of
  // the forms before; the present forms may be nearer than lower bounds.
  [[nodiscard]] std::vector<std::uint32_t> originals_near(const std::vector<RestoredTriangle>& changed) const {
    constexpr double kRounding = 1e-6;
    const double enough = options_.enough * (1 + kRounding);
    std::vector<char> is_near(state_.original.size(), 0);
    const auto find = [&](std::uint32_t sheet, const glm::uvec3& form) {
      const mesh::TriangleTree* const tree = state_.original_trees.find(sheet);
      if (tree == nullptr) return;
      const Box around = box_of(form);
      tree->for_each_near(float_box(form, enough), [&](std::size_t slot) {
        const std::uint32_t t = state_.original_trees.triangle(sheet, static_cast<std::uint32_t>(slot));
        if (!around.is_within(enough, box_of(state_.original[t]))) return;
        std::atomic_ref(is_near[t]).store(1, std::memory_order_relaxed);
      });
    };
    constexpr std::size_t kGrain = 64;
    const auto find_both = [&](std::size_t i) {
      const std::uint32_t t = changed[i].triangle;
      for (const glm::uvec3& form : {changed[i].corners, state_.corners[t]}) find(state_.sheet(t), form);
    };
    for_each_index(changed.size(), find_both, kGrain);
    return listed([&](std::uint32_t t) { return is_near[t] != 0; });
  }

  // Lists the original triangles that satisfy a condition.
  template <class Predicate>
  [[nodiscard]] std::vector<std::uint32_t> listed(const Predicate& holds) const {
    const std::vector<char> marks = marked([&](std::uint32_t t) { return state_.has_original(t) && holds(t); });
    std::vector<std::uint32_t> list;
    for (std::uint32_t t = 0; t < marks.size(); ++t) {
      if (marks[t] != 0) list.push_back(t);
    }
    return list;
  }

  CollapseState& state_;
  std::span<const CollapseLog> logs_;
  const DistanceProofOptions& options_;
  const Context& context_;
  mesh::DistanceLimits limits_;
  ProvenDistances& proven_;
  bool covers_all_ = true;  // the pass measures the whole mesh
  // Boxes around the triangles that the last pass restored, before and after; empty if there are none.
  std::optional<mesh::BoxTree> changes_;
};

// Bounds all changed triangles, each within its sheet, in the order of the triangles.
void bound_by_sheet(const CollapseState& state, const SheetTrees& trees, const mesh::DistanceLimits& limits,
                    const Context& context, Proof& proof) {
  std::vector<DistanceBounds> found;
  const auto add = [&](std::span<const glm::uvec3> triangles, const SheetTrees& to, const auto& counts) {
    // Each round starts from the largest distance of earlier rounds.
    std::size_t round = 1 << 8;
    for (std::size_t begin = 0; begin < triangles.size() && !context.cancelled(); begin += found.size(), round *= 2) {
      found.assign(std::min(round, triangles.size() - begin), {});
      const double known = proof.lower;
      for_each_index(
          found.size(),
          [&](std::size_t i) {
            const auto t = static_cast<std::uint32_t>(begin + i);
            if (!counts(t) || context.cancelled()) return;
            const glm::uvec3& c = triangles[t];
            const mesh::TriangleBound bound = mesh::bound_distance(
                {state.positions[c.x], state.positions[c.y], state.positions[c.z]}, to.tree(state.sheet(t)), limits,
                known, &to == &trees ? 0 : state.original_slot[t]);
            found[i] = {bound.lower, bound.upper};
          },
          kSheetGrain);
      for (const DistanceBounds& bounds : found) {
        proof.lower = std::max(proof.lower, bounds.lower);
        proof.upper = std::max(proof.upper, bounds.upper);
      }
    }
  };
  add(state.corners, state.original_trees,
      [&](std::uint32_t t) { return state.gone[t] == 0 && !state.is_original(t); });
  add(state.original, trees, [&](std::uint32_t t) { return !state.is_original(t); });
}

}  // namespace

Result<Proof> prove_distance(CollapseState& state, std::span<const CollapseLog> logs,
                             const DistanceProofOptions& options, ProvenDistances& proven, const Context& context) {
  return DistanceProof(state, logs, options, proven, context).run();
}

Result<Proof> measure_distance(const CollapseState& state, const Context& context) {
  constexpr double kTolerance = 0.02;
  context.progress().begin("measuring the simplified mesh", 0);
  std::vector<char> new_left_out(state.corners.size());
  std::vector<char> old_left_out(state.corners.size());
  for (std::uint32_t t = 0; t < state.corners.size(); ++t) {
    new_left_out[t] = state.gone[t] != 0 || state.is_original(t) ? 1 : 0;
    old_left_out[t] = state.is_original(t) ? 1 : 0;
  }
  const mesh::DistanceLimits limits{.tolerance = kTolerance, .floor = mesh::float32_resolution(state.positions)};
  Proof proof;
  proof.passes = 1;
  const auto measure = [&](const mesh::PlacedTriangles& from, const mesh::TriangleTree& to) {
    mesh::GreatestDistanceSearch search(from, to, limits, context);
    search.measure_corners();
    const mesh::GreatestDistance found = search.bound_triangles();
    proof.lower = std::max(proof.lower, found.lower);
    proof.upper = std::max(proof.upper, found.upper);
  };
  const SheetTrees trees(state.positions, state.corners, state.gone, state.sheets);
  if (state.sheets.count == 1) {
    measure({state.positions, state.corners, new_left_out}, state.original_trees.tree(0));
    measure({state.positions, state.original, old_left_out}, trees.tree(0));
  } else {
    bound_by_sheet(state, trees, limits, context, proof);
  }
  TRY(context.check());
  return proof;
}

}  // namespace isoextract::edit

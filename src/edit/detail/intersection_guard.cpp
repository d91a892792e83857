#include "edit/detail/intersection_guard.hpp"

#include <algorithm>

#include "base/buffer.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::edit {

IntersectionGuard::IntersectionGuard(CollapseState& state, std::span<const std::uint32_t> patch)
    : state_(state), patch_(patch), tree_(tree_of(state, patch)), slots_(patch.size()), placed_(patch.size()) {
  const auto numbers = tree_.numbers();
  for (std::uint32_t slot = 0; slot < numbers.size(); ++slot) {
    const std::uint32_t t = numbers[slot];
    slots_[t] = slot;
    placed_[slot] = {corners_of(state, patch[t]), t};
    const mesh::PlacedTriangle triangle = placed(placed_[slot].corners);
    placed_[slot].counts = !mesh::are_collinear(triangle.corners[0], triangle.corners[1], triangle.corners[2]);
  }
}

IntersectionGuard::Corners IntersectionGuard::corners_of(const CollapseState& state, std::uint32_t triangle) {
  const glm::uvec3& t = state.corners[triangle];
  return {state.stored[t.x], state.stored[t.y], state.stored[t.z]};
}

mesh::BoxTree IntersectionGuard::tree_of(const CollapseState& state, std::span<const std::uint32_t> patch) {
  Buffer<mesh::BoxTree::Item> items(patch.size());
  for (std::uint32_t i = 0; i < items.size(); ++i) items[i] = {box_of(corners_of(state, patch[i])).center(), i};
  return {items.span(), [&](std::uint32_t i) { return box_of(corners_of(state, patch[i])); }};
}

mesh::PlacedTriangle IntersectionGuard::placed(const Corners& c) {
  return {{glm::dvec3(c[0]), glm::dvec3(c[1]), glm::dvec3(c[2])}};
}

bool IntersectionGuard::meet(const Corners& a, const Corners& b) {
  return box_of(a).meets(box_of(b)) && mesh::find_overlap(placed(a), placed(b)).meet;
}

// Lists the triangles near changed ones, except the triangles around the vertex.
void IntersectionGuard::find_near(std::span<const std::uint32_t> around, std::span<const Changed> changed) {
  mesh::FloatBox box;
  for (const Changed& c : changed) box = box.with(box_of(c.corners));
  ++look_;
  for (const std::uint32_t t : around) at(t).looked = look_;
  near_.clear();
  const mesh::BoxQuery query(box);
  tree_.for_each_slot_near(box, [&](std::size_t slot) {
    const Placed& t = placed_[slot];
    if (!t.counts || t.looked == look_ || !query.meets_triangle(t.corners.data())) return;
    near_.push_back({t.triangle, box_of(t.corners), mesh::CornerLanes(t.corners)});
  });
}

bool IntersectionGuard::allows(std::span<const std::uint32_t> around, std::span<const Changed> changed) {
  find_near(around, changed);
  met_.clear();
  for (std::uint32_t i = 0; i < changed.size(); ++i) {
    const Corners& corners = changed[i].corners;
    const mesh::BoxQuery box(box_of(corners));
    const mesh::PlacedTriangle triangle = placed(corners);
    const mesh::CornerLanes lanes(corners);
    const mesh::PlaneFilter plane(corners);
    for (const Near& near : near_) {
      if (!box.meets(near.box) || plane.is_apart(near.corners)) continue;
      const Corners& other = at(near.triangle).corners;
      if (mesh::PlaneFilter(other).is_apart(lanes)) continue;
      if (mesh::find_overlap(triangle, placed(other)).meet) met_.push_back({i, near.triangle});
    }
    for (std::uint32_t j = 0; j < i; ++j) {
      if (plane.is_apart(mesh::CornerLanes(changed[j].corners))) continue;
      if (meet(corners, changed[j].corners)) met_.push_back({i, changed[j].triangle});
    }
  }
  if (met_.empty()) return true;
  if (!met_before(around)) return false;
  for (const auto& [i, t] : met_) state_.tangled[patch_[changed[i].triangle]] = state_.tangled[patch_[t]] = 1;
  return true;
}

// Returns whether t may be in an intersecting pair of the original mesh. Changed triangles of two patches may
// intersect, too, until undo_intersections() runs.
bool IntersectionGuard::may_have_met(std::uint32_t t) const {
  return at(t).counts && (state_.changed_by[patch_[t]] == kNone || state_.tangled[patch_[t]] != 0);
}

// Returns whether each partner in met_ intersected a triangle around the vertex before the collapse, too, and the
// number of pairs does not grow.
bool IntersectionGuard::met_before(std::span<const std::uint32_t> around) const {
  std::size_t before = 0;
  for (std::size_t i = 0; i < around.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (!may_have_met(around[i]) || !may_have_met(around[j])) continue;
      before += meet(at(around[i]).corners, at(around[j]).corners) ? 1 : 0;
    }
  }
  std::vector<std::uint32_t> partners;
  for (const auto& [i, t] : met_) {
    if (at(t).looked != look_) partners.push_back(t);
  }
  if (before == 0 && partners.size() < met_.size()) return false;
  std::ranges::sort(partners);
  partners.erase(std::unique(partners.begin(), partners.end()), partners.end());
  for (const std::uint32_t partner : partners) {
    const auto pairs = static_cast<std::size_t>(std::ranges::count_if(around, [&](std::uint32_t t) {
      return may_have_met(t) && may_have_met(partner) && meet(at(t).corners, at(partner).corners);
    }));
    if (pairs == 0) return false;
    before += pairs;
  }
  return met_.size() <= before;
}

void IntersectionGuard::replace(std::span<const std::uint32_t> around, std::span<const Changed> changed) {
  for (const std::uint32_t t : around) at(t).counts = false;
  for (const Changed& c : changed) {
    Placed& own = at(c.triangle);
    own.counts = true;
    own.corners = c.corners;
    tree_.enlarge(slots_[c.triangle], box_of(c.corners));
  }
}

}  // namespace isoextract::edit

#include "edit/detail/edge_collapse.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "edit/detail/intersection_guard.hpp"
#include "edit/detail/patch_mesh.hpp"
#include "edit/detail/quadric.hpp"
#include "mesh/closest_point.hpp"
#include "mesh/distance_bound.hpp"

namespace isoextract::edit {
namespace {

class PatchCollapse : private PatchMesh {
 public:
  PatchCollapse(CollapseState& state, std::span<const std::uint32_t> patch, const CollapseVertices& vertices,
                const CollapseLimits& limits, std::uint32_t first)
      : PatchMesh(state, patch, vertices.locked),
        limit_squared_(limits.distance * limits.distance),
        proven_(limits.proven),
        least_triangles_(limits.triangles),
        left_(patch.size()) {
    if (limits.is_guarded) guard_.emplace(state, patch);
    log_.first = first;
    version_.assign(vertices_.size(), 0);
    least_.resize(vertices_.size());
    waits_.assign(vertices_.size(), 0);
    sum_quadrics();
  }

  CollapseLog run(const CollapseVertices& vertices) {
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      if (vertices.wanted[vertices_[v]] != 0) push(v);
    }
    while (!queue_.empty() && left_ > least_triangles_) {
      const Candidate candidate = queue_.top();
      if (candidate.cost > limit_squared_) break;
      queue_.pop();
      if (candidate.version != version_[candidate.vertex]) continue;
      waits_[candidate.vertex] = 0;
      try_to_remove(candidate);
    }
    return std::move(log_);
  }

 private:
  struct Candidate {
    double cost;
    std::uint32_t vertex;
    std::uint32_t version;
    std::uint32_t to;                               // kNone: not chosen yet, `cost` is a lower bound
    bool operator<(const Candidate& other) const {  // std::priority_queue has the greatest on top
      return cost != other.cost ? cost > other.cost : vertex > other.vertex;
    }
  };
  struct Near {
    double distance_squared;  // largest for a new triangle and its samples
    std::uint32_t slot;       // a near slot in the tree of the original mesh
    DistanceBounds known;
  };
  struct Attached {
    std::uint32_t triangle;
    std::uint32_t sample;
    double distance_squared;
  };

  void sum_quadrics() {
    quadrics_.resize(vertices_.size());
    for (const Corners& t : corners_) {
      const glm::dvec3 cross = cross_product(t);
      const double length = glm::length(cross);
      if (!(length > 0)) continue;
      for (int corner = 0; corner < 3; ++corner) {
        quadrics_[t[corner]].add_plane(cross / length, places_[t.x], length / 2);
        const std::uint32_t from = t[corner];
        const std::uint32_t to = t[(corner + 1) % 3];
        if (leaves_[from] != 1 || leaves_[to] != 1 || !is_boundary_edge(from, to)) continue;
        const glm::dvec3 edge = places_[to] - places_[from];
        const glm::dvec3 upright = glm::cross(edge, cross);
        const double size = glm::length(upright);
        if (!(size > 0)) continue;
        for (const std::uint32_t end : {from, to}) {
          quadrics_[end].add_plane(upright / size, places_[from], glm::dot(edge, edge));
        }
      }
    }
  }

  // The area term collapses short edges and vertices of small area first in flat regions, so no vertex gets very many
  // edges.
  [[nodiscard]] double least_cost(std::uint32_t from, std::uint32_t to) const {
    constexpr double kOfArea = 1e-10;
    const glm::dvec3 way = places_[to] - places_[from];
    const double area = quadrics_[from].weight + quadrics_[to].weight + glm::dot(way, way);
    return mean_square(quadrics_[from], quadrics_[to], places_[to]) + kOfArea * area;
  }

  void push(std::uint32_t v) {
    ++version_[v];
    if (fixed_[v] != 0) return;
    look_around(v, pushed_);
    least_[v] = std::numeric_limits<double>::infinity();
    for (const std::uint32_t to : pushed_.neighbors) least_[v] = std::min(least_[v], least_cost(v, to));
    queue(v);
  }

  // Updates the candidate of v, a neighbor of `to`, after another vertex has collapsed to `to`. Collapses to others
  // cost as much as before.
  void push_neighbor(std::uint32_t v, std::uint32_t to) {
    if (fixed_[v] != 0) return;
    const double cost = least_cost(v, to);
    if (waits_[v] != 0 && !(cost < least_[v])) return;  // its candidate still holds
    ++version_[v];
    least_[v] = std::min(least_[v], cost);
    queue(v);
  }

  void queue(std::uint32_t v) {
    waits_[v] = least_[v] <= limit_squared_ ? 1 : 0;
    if (waits_[v] != 0) queue_.push({least_[v], v, version_[v], kNone});
  }

  void try_to_remove(const Candidate& candidate) {
    const std::uint32_t v = candidate.vertex;
    look_around(v, ring_);
    prepared_ = kNone;
    if (candidate.to == kNone) {
      look_at_targets(candidate);
    } else {
      collapse_if_near(v, candidate.to);
    }
  }

  // Collapses now, or queues the candidate until its cost is among the lowest.
  void collapse_in_turn(const Candidate& candidate) {
    constexpr double kMuchMore = 10;  // factor of the squared distance; strict order would repeat many searches
    if (!queue_.empty() && candidate.cost > kMuchMore * queue_.top().cost) {
      queue_.push(candidate);
      return;
    }
    collapse_if_near(candidate.vertex, candidate.to);
  }

  void collapse_if_near(std::uint32_t v, std::uint32_t to) {
    if (prepared_ != to) {
      list_apexes(ring_, to, apexes_);
      make_new(v, to);
      attach(v);
      look_from_new(to, 0);
      prepared_ = to;
    }
    if (!new_are_near()) return;
    if (guard_) {
      list_changes();
      if (!guard_->allows(around_, changed_)) {
        ++log_.refused;
        return;
      }
      guard_->replace(around_, changed_);
    }
    collapse(v, to);
  }

  // Expects ring_ to be the ring of the candidate's vertex.
  void look_at_targets(const Candidate& candidate) {
    const std::uint32_t v = candidate.vertex;
    // Tries the best targets by quadric error. A vertex that fails is tried again only after a change around it.
    constexpr std::size_t kTries = 2;
    targets_.clear();
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t to : ring_.neighbors) {
      const double cost = least_cost(v, to);
      least = std::min(least, cost);
      if (cost <= limit_squared_) targets_.emplace_back(cost, to);
    }
    if (least > least_[v]) {  // other collapses have made all of v cost more
      least_[v] = least;
      if (!queue_.empty() && least > queue_.top().cost) return queue(v);
    }
    std::sort(targets_.begin(), targets_.end());
    shapes_.clear();
    for (const Around& a : ring_.around) shapes_.push_back(shape(corners_[a.triangle]));
    std::size_t tries = 0;
    for (const auto& [cost, to] : targets_) {
      if (!keeps_topology(v, to)) continue;
      make_new(v, to);
      prepared_ = kNone;
      if (!keeps_shape(v)) continue;
      prepared_ = to;
      double sampled = std::max(cost, attach(v));
      if (sampled <= limit_squared_) sampled = look_from_new(to, sampled);
      if (sampled <= limit_squared_) {
        collapse_in_turn({std::max(sampled, candidate.cost), v, candidate.version, to});
        return;
      }
      if (++tries == kTries) return;
    }
  }

  // Checks the link condition: v and `to` share only the neighbors opposite their edge, and belong to no tetrahedron
  // and no triangular hole. A vertex of a curve stays on it, and no leaf between its two curve edges is a single
  // triangle, whose collapse would merge these edges. No new edge joins two locked vertices.
  [[nodiscard]] bool keeps_topology(std::uint32_t v, std::uint32_t to) {
    list_apexes(ring_, to, apexes_);
    const std::size_t leaves = leaves_[v];
    if (apexes_.size() != (leaves > 0 ? leaves : 2)) return false;
    if (leaves == 1 && leaves_[to] == 0) return false;
    if (leaves == 2 && !is_curve_edge(ring_, to)) return false;
    for (std::size_t i = 0; i < apexes_.size(); ++i) {
      if (std::find(apexes_.begin(), apexes_.begin() + static_cast<std::ptrdiff_t>(i), apexes_[i]) !=
          apexes_.begin() + static_cast<std::ptrdiff_t>(i)) {
        return false;
      }
      if (leaves > 0 && is_curve_edge(ring_, apexes_[i])) return false;
    }
    // The triangle that replaces these three may already exist in another patch.
    const bool three_around = leaves == 0 && ring_.around.size() == 3;
    if (three_around && locked_[to] != 0 && locked_[apexes_[0]] != 0 && locked_[apexes_[1]] != 0) return false;
    for (const std::uint32_t neighbor : ring_.neighbors) {
      if (neighbor == to || std::ranges::find(apexes_, neighbor) != apexes_.end()) continue;
      if (locked_[neighbor] != 0 && locked_[to] != 0) return false;
      if (joined(neighbor, to)) return false;
    }
    if (leaves > 0)
      return keeps_touching_parts(v, to);  // no triangle of v has two apexes: they are in different leaves
    for (std::uint32_t c = first_corner_[to]; c != kNone; c = next_corner_[c]) {
      if (removed_[c / 3] != 0) continue;
      const Corners& t = corners_[c / 3];
      const auto has = [&](std::uint32_t w) { return t.x == w || t.y == w || t.z == w; };
      if (!has(v) && has(apexes_[0]) && has(apexes_[1])) return false;
    }
    return true;
  }

  // Returns whether a curve along which a label touches itself keeps an inner vertex after the collapse of v.
  [[nodiscard]] bool keeps_touching_parts(std::uint32_t v, std::uint32_t to) const {
    if (!state_.has_role(vertices_[v], VertexRole::touching) || is_touching(to)) return true;
    return std::ranges::any_of(ring_.neighbors,
                               [&](std::uint32_t w) { return w != to && is_touching(w) && is_curve_edge(ring_, w); });
  }

  // Lists in new_ the triangles of v that remain, with `to` instead of v.
  void make_new(std::uint32_t v, std::uint32_t to) {
    new_.clear();
    for (const Around& a : ring_.around) {
      if (a.from == to || a.next == to) continue;
      Corners t = corners_[a.triangle];
      for (int corner = 0; corner < 3; ++corner) {
        if (t[corner] == v) t[corner] = to;
      }
      new_.emplace_back(a.triangle, t);
    }
  }

  // No triangle may turn by more than about 75 degrees, or become a sliver unless one was nearly as thin. A sliver has
  // no reliable normal, so its successor is compared with the sum of all triangles of its sheet around v. `shapes_` are
  // those of the triangles around v.
  [[nodiscard]] bool keeps_shape(std::uint32_t v) const {
    constexpr double kLeastCosine = 0.25;
    constexpr double kThin = 1e-2;
    constexpr double kThinnest = 1e-3;
    if (new_.empty()) return false;
    constexpr double kOfThinnest = 0.5;
    double thin_enough = kThinnest;
    for (const Shape& shape : shapes_) thin_enough = std::min(thin_enough, kOfThinnest * shape.thickness);
    auto next = new_.begin();  // they are in the order of the triangles around v
    for (std::size_t i = 0; i < shapes_.size() && next != new_.end(); ++i) {
      if (ring_.around[i].triangle != next->first) continue;
      const auto& [f, t] = *next++;
      const Shape after = shape(t);
      if (!(after.thickness > thin_enough) || !has_area(t) || joins_sides(t)) return false;
      const Shape& own = shapes_[i];
      const glm::dvec3 before = own.thickness > kThin ? own.cross : sum_around(sheet(f));
      if (!(glm::dot(before, after.cross) > kLeastCosine * glm::length(before) * glm::length(after.cross)))
        return false;
    }
    return first_corner_[v] != kNone;
  }

  // Returns the sum of the cross products of a sheet's triangles around v.
  [[nodiscard]] glm::dvec3 sum_around(std::uint32_t of_sheet) const {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < shapes_.size(); ++i) {
      if (sheet(ring_.around[i].triangle) == of_sheet) sum += shapes_[i].cross;
    }
    return sum;
  }

  // Finds the nearest new triangle of the same sheet for v and for each sample around v. Returns the largest squared
  // distance, or infinity if it exceeds the limit.
  double attach(std::uint32_t v) {
    attached_.clear();
    targets_of_new_.clear();
    for (const auto& [f, t] : new_) targets_of_new_.emplace_back(places_[t.x], places_[t.y], places_[t.z]);
    double greatest = 0;
    const auto add = [&](std::uint32_t sample, std::uint32_t of_sheet) {
      const glm::dvec3 p = glm::dvec3(state_.positions[sample]) - origin_;
      double least = std::numeric_limits<double>::infinity();
      std::uint32_t nearest = 0;
      for (std::size_t i = 0; i < new_.size(); ++i) {
        if (sheet(new_[i].first) != of_sheet) continue;
        const double squared = targets_of_new_[i].distance_squared(p);
        if (squared < least) {
          least = squared;
          nearest = new_[i].first;
        }
      }
      attached_.push_back({nearest, sample, least});
      greatest = std::max(greatest, least);
      return least <= limit_squared_;
    };
    const auto beyond = std::numeric_limits<double>::infinity();
    list_sheets(ring_, sheets_);
    for (const std::uint32_t of_sheet : sheets_) {
      if (!add(vertices_[v], of_sheet)) return beyond;
    }
    keep_farthest();
    for (const Around& a : ring_.around) {
      const std::uint32_t t = triangles_[a.triangle];
      for (std::uint32_t s = state_.first_sample[t]; s != kNone; s = state_.next_sample[s]) {
        if (!add(s, state_.sheet(t))) return beyond;
      }
    }
    return greatest;
  }

  // A vertex can be a sample of one triangle only: keeps the sheet that is farthest from v.
  void keep_farthest() { attached_ = {*std::ranges::max_element(attached_, {}, &Attached::distance_squared)}; }

  // Returns the largest squared distance from the midpoints of new edges to the original mesh, at least `known`. Call
  // attach(v) first; `apexes_` are those of v and `to`, whose edges are not new.
  double look_from_new(std::uint32_t to, double known) {
    double farthest = known;
    near_.clear();
    for (const auto& [f, t] : new_) {
      const mesh::TriangleTree& tree = state_.original_tree(triangles_[f]);
      std::uint32_t slot = state_.original_slot[triangles_[f]];
      double of_triangle = 0;
      const auto look = [&](const glm::dvec3& p) {
        const auto nearest = tree.nearest(p + origin_, slot, farthest);
        of_triangle = std::max(of_triangle, nearest.distance_squared);
        slot = nearest.slot;
      };
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t end = t[(corner + 1) % 3];
        if (t[corner] != to || std::ranges::find(apexes_, end) != apexes_.end()) continue;
        look(0.5 * (places_[to] + places_[end]));
      }
      farthest = std::max(farthest, of_triangle);
      if (farthest > limit_squared_ && known > 0) return farthest;
      for (const Attached& a : attached_) {
        if (a.triangle == f) of_triangle = std::max(of_triangle, a.distance_squared);
      }
      near_.push_back({of_triangle, slot, {}});
    }
    return farthest;
  }

  // Returns whether every point of the new triangles is within `proven_`. Call look_from_new() first.
  [[nodiscard]] bool new_are_near() {
    constexpr double kClearlyNear = 0.5;  // fraction of the limit: nearer triangles are not measured
    if (!std::isfinite(proven_)) return true;
    mesh::DistanceLimits limits;
    limits.tolerance = 0;
    limits.floor = 1e-2 * proven_;
    limits.enough = proven_;
    limits.refuse = proven_;
    limits.max_parts = 64;  // a harder case is close to the limit
    measured_.clear();
    for (std::uint32_t i = 0; i < new_.size(); ++i) {
      if (near_[i].distance_squared >= kClearlyNear * kClearlyNear * proven_ * proven_) measured_.push_back(i);
    }
    // The farthest first: it is the likeliest to be too far.
    std::ranges::sort(measured_, std::greater(), [&](std::uint32_t i) { return near_[i].distance_squared; });
    for (const std::uint32_t i : measured_) {
      const auto& [f, t] = new_[i];
      const std::array<glm::dvec3, 3> corners{places_[t.x] + origin_, places_[t.y] + origin_, places_[t.z] + origin_};
      const mesh::TriangleTree& tree = state_.original_tree(triangles_[f]);
      const auto covered = state_.original_cover.bound(corners, tree, sheet(f), near_[i].slot, proven_);
      const mesh::TriangleBound found =
          covered ? *covered : mesh::bound_distance(corners, tree, limits, 0, near_[i].slot);
      if (!(found.upper <= proven_)) return false;
      near_[i].known = {found.lower, found.upper};
    }
    return true;
  }

  // Lists the triangles around v for the guard. Call make_new(v, to) first.
  void list_changes() {
    around_.clear();
    changed_.clear();
    for (const Around& a : ring_.around) around_.push_back(a.triangle);
    const auto stored = [&](std::uint32_t vertex) { return state_.stored[vertices_[vertex]]; };
    for (const auto& [f, t] : new_) changed_.push_back({f, {stored(t.x), stored(t.y), stored(t.z)}});
  }

  // Call make_new(v, to) and attach(v) first.
  void collapse(std::uint32_t v, std::uint32_t to) {
    const std::uint32_t number = log_.first + static_cast<std::uint32_t>(log_.collapses.size());
    log_.collapses.push_back({vertices_[v], vertices_[to], static_cast<std::uint32_t>(log_.records.size()),
                              static_cast<std::uint32_t>(ring_.around.size())});
    for (const Around& a : ring_.around) {
      const std::uint32_t t = triangles_[a.triangle];
      log_.records.push_back({t, state_.changed_by[t]});
      state_.changed_by[t] = number;
      state_.first_sample[t] = kNone;
      if (a.from != to && a.next != to) continue;
      removed_[a.triangle] = 1;
      state_.gone[t] = 1;
      --left_;
      ++log_.removed;
    }
    // Appends the corner list of v to that of `to`.
    std::uint32_t* end = &first_corner_[to];
    while (*end != kNone) end = &next_corner_[*end];
    *end = first_corner_[v];
    first_corner_[v] = kNone;
    for (std::size_t i = 0; i < new_.size(); ++i) {
      const auto& [f, t] = new_[i];
      state_.known[triangles_[f]] = near_[i].known;
      log_.farthest_squared = std::max(log_.farthest_squared, near_[i].distance_squared);
      corners_[f] = t;
      state_.corners[triangles_[f]] = {vertices_[t.x], vertices_[t.y], vertices_[t.z]};
    }
    keep_samples();
    ++version_[v];
    fixed_[v] = 1;
    quadrics_[to].add(quadrics_[v]);
    push(to);
    look_around(to, ring_);
    for (const std::uint32_t neighbor : ring_.neighbors) push_neighbor(neighbor, to);
  }

  void keep_samples() {
    constexpr std::size_t kMostSamples = CollapseState::kMostSamples;
    if (attached_.size() > kMostSamples) {
      std::sort(attached_.begin(), attached_.end(), [](const Attached& a, const Attached& b) {
        if (a.triangle != b.triangle) return a.triangle < b.triangle;
        return a.distance_squared != b.distance_squared ? a.distance_squared > b.distance_squared : a.sample < b.sample;
      });
    }
    std::size_t of_triangle = 0;
    for (std::size_t i = 0; i < attached_.size(); ++i) {
      const Attached& a = attached_[i];
      of_triangle = i > 0 && attached_[i - 1].triangle == a.triangle ? of_triangle + 1 : 0;
      if (of_triangle >= kMostSamples) continue;
      std::uint32_t& first = state_.first_sample[triangles_[a.triangle]];
      state_.next_sample[a.sample] = first;
      first = a.sample;
    }
  }

  double limit_squared_;
  double proven_;
  std::size_t least_triangles_;
  std::size_t left_;
  std::optional<IntersectionGuard> guard_;  // empty: not guarded
  CollapseLog log_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> version_;  // counts changes around a vertex; candidates with an older version are void
  std::vector<double> least_;           // lower bounds of the costs of vertices; 0 before the first push
  std::vector<char> waits_;             // 1: the queue holds a candidate of the present version without a chosen target
  std::priority_queue<Candidate> queue_;
  Ring ring_, pushed_;
  std::vector<std::pair<double, std::uint32_t>> targets_;
  std::vector<Shape> shapes_;  // of ring_.around
  std::vector<std::uint32_t> apexes_, sheets_;
  std::uint32_t prepared_ = kNone;  // the target that the members below belong to, or kNone
  std::vector<std::pair<std::uint32_t, Corners>> new_;
  std::vector<mesh::ClosestPointTriangle> targets_of_new_;
  std::vector<Attached> attached_;
  std::vector<Near> near_;                           // for each of new_
  std::vector<std::uint32_t> measured_;              // indices into new_ that new_are_near() measures
  std::vector<std::uint32_t> around_;                // the triangles of ring_
  std::vector<IntersectionGuard::Changed> changed_;  // new_ with positions
};

}  // namespace

CollapseLog collapse_edges(CollapseState& state, std::span<const std::uint32_t> patch, const CollapseVertices& vertices,
                           const CollapseLimits& limits, std::uint32_t first) {
  if (patch.empty()) return {first, 0, 0, 0, {}, {}};
  return PatchCollapse(state, patch, vertices, limits, first).run(vertices);
}

}  // namespace isoextract::edit

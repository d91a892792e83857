#include "edit/detail/loop_triangulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "edit/detail/hole_bridges.hpp"
#include "edit/detail/polygon_ears.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

using PointPair = std::pair<std::uint32_t, std::uint32_t>;

PointPair pair_of(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

// Triangles with their neighbors, and the operations on their edges.
class Triangulation {
 public:
  Triangulation(std::span<const glm::dvec2> points, Ears ears)
      : points_(points.begin(), points.end()), triangles_(std::move(ears.triangles)), twin_(std::move(ears.twins)) {}

  // Runs Lawson's flips. Each increases a bounded measure of quality; rounding could make flips cycle, so their number
  // is limited.
  void flip_to_delaunay() {
    std::vector<HalfEdge> waiting(twin_.size());
    for (HalfEdge h = 0; h < twin_.size(); ++h) waiting[h] = h;
    std::uint64_t left = 64 * std::uint64_t{twin_.size()};
    while (!waiting.empty() && left > 0) {
      const HalfEdge h = waiting.back();
      waiting.pop_back();
      if (twin_[h] == kNoHalfEdge || !is_flip_better(h)) continue;
      --left;
      flip(h);
      for (const HalfEdge outer : {following(h), preceding(h), following(twin_[h]), preceding(twin_[h])}) {
        waiting.push_back(outer);
      }
    }
  }

  // Splits each inner edge whose end points another edge joins, too: an inner edge, a loop edge or one of `taken`.
  void split_duplicate_edges(std::span<const PointPair> taken, std::vector<PointPair>& midpoints) {
    std::vector<PointPair> edges(taken.begin(), taken.end());
    for (HalfEdge h = 0; h < twin_.size(); ++h) {
      if (twin_[h] == kNoHalfEdge || h < twin_[h]) edges.push_back(pair_of(start(h), end(h)));
    }
    std::ranges::sort(edges);
    std::vector<bool> twice(twin_.size());
    for (HalfEdge h = 0; h < twin_.size(); ++h) {
      if (twin_[h] == kNoHalfEdge || h > twin_[h]) continue;
      const auto [first, last] = std::equal_range(edges.begin(), edges.end(), pair_of(start(h), end(h)));
      twice[h] = last - first > 1;
    }
    for (HalfEdge h = 0; h < twin_.size(); ++h) {
      if (!twice[h]) continue;
      midpoints.push_back(pair_of(start(h), end(h)));
      const HalfEdge t = twin_[h];
      const auto first = static_cast<HalfEdge>(twin_.size());
      part(h);
      // Moves the flags along with their half-edges.
      twice.resize(twin_.size());
      twice[following(first)] = twice[following(h)];
      twice[following(first + 3)] = twice[following(t)];
      twice[h] = twice[following(h)] = twice[following(t)] = false;
    }
  }

  [[nodiscard]] std::uint64_t turned(double rounding) const {
    return static_cast<std::uint64_t>(std::ranges::count_if(triangles_, [&](const glm::uvec3& t) {
      const glm::dvec2 a = points_[t.x];
      const glm::dvec2 b = points_[t.y];
      const glm::dvec2 c = points_[t.z];
      if (mesh::orientation_2d(a, b, c) >= 0) return false;
      const double across = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
      return -across > rounding * std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
    }));
  }

  [[nodiscard]] std::vector<glm::uvec3> take() && { return std::move(triangles_); }

 private:
  static HalfEdge following(HalfEdge h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static HalfEdge preceding(HalfEdge h) { return h % 3 == 0 ? h + 2 : h - 1; }
  [[nodiscard]] std::uint32_t start(HalfEdge h) const { return triangles_[h / 3][static_cast<int>(h % 3)]; }
  [[nodiscard]] std::uint32_t end(HalfEdge h) const { return start(following(h)); }
  [[nodiscard]] std::uint32_t tip(HalfEdge h) const { return start(preceding(h)); }

  void pair(HalfEdge a, HalfEdge b) {
    if (a != kNoHalfEdge) twin_[a] = b;
    if (b != kNoHalfEdge) twin_[b] = a;
  }

  // Returns whether the angles opposite the edge sum to more than 180 degrees and the other diagonal is inside.
  [[nodiscard]] bool is_flip_better(HalfEdge h) const {
    const std::uint32_t c = tip(h);
    const std::uint32_t d = tip(twin_[h]);
    if (c == d) return false;
    const glm::dvec2& a = points_[start(h)];
    const glm::dvec2& b = points_[end(h)];
    const auto angle = [&](const glm::dvec2& from, const glm::dvec2& right, const glm::dvec2& left) {
      const glm::dvec2 u = right - from;
      const glm::dvec2 v = left - from;
      const double size = std::sqrt(glm::dot(u, u) * glm::dot(v, v));
      return size > 0 ? glm::dvec2(glm::dot(u, v), u.x * v.y - u.y * v.x) / size : glm::dvec2(1, 0);
    };
    const glm::dvec2 at_c = angle(points_[c], a, b);
    const glm::dvec2 at_d = angle(points_[d], b, a);
    constexpr double kClearly = 1e-9;
    if (at_c.x * at_d.y + at_c.y * at_d.x > -kClearly) return false;
    return mesh::orientation_2d(points_[c], a, points_[d]) > 0 && mesh::orientation_2d(points_[d], b, points_[c]) > 0;
  }

  // Turns triangles abc and bad into dca and cdb; then h runs from d to c, and its twin from c to d.
  void flip(HalfEdge h) {
    const HalfEdge t = twin_[h];
    const std::uint32_t a = start(h);
    const std::uint32_t b = end(h);
    const std::uint32_t c = tip(h);
    const std::uint32_t d = tip(t);
    const HalfEdge bc = twin_[following(h)];
    const HalfEdge ca = twin_[preceding(h)];
    const HalfEdge ad = twin_[following(t)];
    const HalfEdge db = twin_[preceding(t)];
    set(h, d, c, a);
    set(t, c, d, b);
    twin_[following(h)] = twin_[preceding(h)] = twin_[following(t)] = twin_[preceding(t)] = kNoHalfEdge;
    pair(following(h), ca);
    pair(preceding(h), ad);
    pair(following(t), db);
    pair(preceding(t), bc);
  }

  // Sets the triangle of h to p, q, r, with h from p to q.
  void set(HalfEdge h, std::uint32_t p, std::uint32_t q, std::uint32_t r) {
    glm::uvec3& t = triangles_[h / 3];
    t[static_cast<int>(h % 3)] = p;
    t[static_cast<int>(following(h) % 3)] = q;
    t[static_cast<int>(preceding(h) % 3)] = r;
  }

  // Splits the edge at its midpoint, and each of its triangles in two.
  void part(HalfEdge h) {
    const HalfEdge t = twin_[h];
    const std::uint32_t a = start(h);
    const std::uint32_t b = end(h);
    const std::uint32_t c = tip(h);
    const std::uint32_t d = tip(t);
    const auto m = static_cast<std::uint32_t>(points_.size());
    points_.push_back((points_[a] + points_[b]) / 2.0);
    const auto first = static_cast<HalfEdge>(twin_.size());
    const HalfEdge second = first + 3;
    const HalfEdge bc = twin_[following(h)];
    const HalfEdge ad = twin_[following(t)];
    set(h, a, m, c);
    set(t, b, m, d);
    triangles_.emplace_back(m, b, c);
    triangles_.emplace_back(m, a, d);
    twin_.insert(twin_.end(), 6, kNoHalfEdge);
    twin_[following(h)] = twin_[following(t)] = kNoHalfEdge;
    pair(h, second);
    pair(t, first);
    pair(following(first), bc);
    pair(following(second), ad);
    pair(preceding(first), following(h));
    pair(preceding(second), following(t));
  }

  std::vector<glm::dvec2> points_;
  std::vector<glm::uvec3> triangles_;
  std::vector<HalfEdge> twin_;
};

}  // namespace

Result<LoopTriangles> triangulate_loops(std::span<const glm::dvec2> points, std::span<const std::uint32_t> next,
                                        std::span<const PointPair> taken, double rounding, const Context& context) {
  LoopTriangles result;
  if (points.empty()) return result;
  // An upper bound of nodes, strips, cells and half-edges together.
  constexpr std::uint64_t kBytesAPoint = 400;
  const auto memory = TRY(context.reserve(points.size() * kBytesAPoint + taken.size_bytes(), "the triangles of a cap"));
  const BridgedLoops loops = bridge_holes(points, next);
  Ears ears;
  ears.of_node.assign(loops.nodes.size(), kNoHalfEdge);
  ears.triangles.reserve(loops.nodes.size());
  ears.twins.reserve(3 * loops.nodes.size());
  for (const std::uint32_t polygon : loops.polygons) {
    TRY(context.check());
    if (clip_ears(points, loops.nodes, polygon, ears, rounding)) continue;
    return fail(ErrorCode::input, "the program cannot cap the cut: a cut line encloses no area",
                {{Remedy::change, Setting::cuts, "a little away from this cut"},
                 {Remedy::leave_out, Setting::cap, "the cut then stays open"}});
  }
  for (const auto& [there, back] : loops.bridges) {
    ears.twins[ears.of_node[there]] = ears.of_node[back];
    ears.twins[ears.of_node[back]] = ears.of_node[there];
  }
  Triangulation triangulation(points, std::move(ears));
  triangulation.flip_to_delaunay();
  triangulation.split_duplicate_edges(taken, result.midpoints);
  result.turned = triangulation.turned(rounding);
  result.triangles = std::move(triangulation).take();
  return result;
}

}  // namespace isoextract::edit

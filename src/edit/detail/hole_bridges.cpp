#include "edit/detail/hole_bridges.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "edit/detail/pinch_points.hpp"
#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kNoNode = std::numeric_limits<std::uint32_t>::max();

// Orders by x, then by y.
bool is_before(const glm::dvec2& a, const glm::dvec2& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

class HoleBridges {
 public:
  HoleBridges(std::span<const glm::dvec2> points, std::span<const std::uint32_t> next) : points_(points) {
    result_.nodes.resize(points.size());
    for (std::uint32_t p = 0; p < points.size(); ++p) {
      result_.nodes[p].point = p;
      result_.nodes[p].next = next[p];
      result_.nodes[next[p]].prev = p;
    }
    split_at_pinch_points(points_, result_);
    find_loops();
  }

  BridgedLoops run() {
    std::vector<std::uint32_t> holes;
    for (std::uint32_t l = 0; l < loops_.size(); ++l) {
      if (loops_[l].twice_area < 0) {
        holes.push_back(l);
      } else {
        result_.polygons.push_back(loops_[l].first);
      }
    }
    if (!holes.empty()) {
      make_rows();
      std::ranges::sort(holes, [&](std::uint32_t a, std::uint32_t b) {
        const glm::dvec2& p = place(loops_[a].first);
        const glm::dvec2& q = place(loops_[b].first);
        return p != q ? is_before(p, q) : a < b;
      });
      for (const std::uint32_t hole : holes) {
        const std::uint32_t to = seen_from(loops_[hole].first);
        if (to == kNoNode) {
          result_.polygons.push_back(loops_[hole].first);
        } else {
          join(to, loops_[hole].first);
          loops_[hole].joined = true;
        }
      }
    }
    return std::move(result_);
  }

 private:
  struct Loop {
    std::uint32_t first;  // the node that is_before() all other nodes
    double twice_area = 0;
    bool joined = false;  // bounds the filled region as part of a polygon
  };

  [[nodiscard]] const glm::dvec2& place(std::uint32_t node) const { return points_[result_.nodes[node].point]; }

  void find_loops() {
    loop_of_.assign(result_.nodes.size(), kNoNode);
    for (std::uint32_t start = 0; start < result_.nodes.size(); ++start) {
      if (loop_of_[start] != kNoNode) continue;
      Loop loop{start};
      const glm::dvec2 from = place(start);
      for (std::uint32_t n = start; loop_of_[n] == kNoNode; n = result_.nodes[n].next) {
        loop_of_[n] = static_cast<std::uint32_t>(loops_.size());
        const glm::dvec2 a = place(n) - from;
        const glm::dvec2 b = place(result_.nodes[n].next) - from;
        loop.twice_area += a.x * b.y - a.y * b.x;
        if (is_before(place(n), place(loop.first))) loop.first = n;
      }
      loop.joined = loop.twice_area > 0;
      loops_.push_back(loop);
    }
  }

  // Lists edges by the strips they cross; about as many strips as edges along a side, if edges are short.
  void make_rows() {
    low_ = std::numeric_limits<double>::infinity();
    double high = -low_;
    double heights = 0;
    for (std::uint32_t n = 0; n < result_.nodes.size(); ++n) {
      low_ = std::min(low_, place(n).y);
      high = std::max(high, place(n).y);
      heights += std::abs(place(n).y - place(result_.nodes[n].next).y);
    }
    const double count = static_cast<double>(result_.nodes.size());
    height_ = std::max((high - low_) / (2 * std::sqrt(count)), heights / (4 * count));
    if (!(height_ > 0)) height_ = 1;
    rows_.resize(row_of(high) + 1);
    for (std::uint32_t n = 0; n < result_.nodes.size(); ++n) list(n);
  }

  [[nodiscard]] std::size_t row_of(double y) const { return static_cast<std::size_t>((y - low_) / height_); }

  void list(std::uint32_t n) {
    const double a = place(n).y;
    const double b = place(result_.nodes[n].next).y;
    const std::size_t last = row_of(std::max(a, b));
    for (std::size_t row = row_of(std::min(a, b)); row <= last; ++row) rows_[row].push_back(n);
  }

  // Returns the node to join the hole's first node to, or kNoNode.
  [[nodiscard]] std::uint32_t seen_from(std::uint32_t hole) const {
    const glm::dvec2& p = place(hole);
    std::uint32_t edge = kNoNode;
    double nearest = -std::numeric_limits<double>::infinity();
    for (const std::uint32_t n : rows_[row_of(p.y)]) {
      if (!loops_[loop_of_[n]].joined) continue;
      const glm::dvec2& a = place(n);
      const glm::dvec2& b = place(result_.nodes[n].next);
      // Edges that run downward have the filled region at larger x.
      if (a.y <= b.y || p.y > a.y || p.y < b.y || mesh::orientation_2d(a, b, p) < 0) continue;
      const double x = a.x + (p.y - a.y) * ((b.x - a.x) / (b.y - a.y));
      if (x > nearest) {
        nearest = x;
        edge = n;
      }
    }
    if (edge == kNoNode) return kNoNode;
    const std::uint32_t end = result_.nodes[edge].next;
    const bool from_start = place(edge).x < place(end).x;
    return best_in_triangle(hole, {std::min(nearest, p.x), p.y}, from_start ? edge : end);
  }

  // Chooses among the nodes in the triangle of the hole's first node p, the point seen on its left, and the farther
  // left end of the seen edge. Returns the node whose direction from p is nearest to the left: nothing can hide it.
  [[nodiscard]] std::uint32_t best_in_triangle(std::uint32_t hole, const glm::dvec2& seen, std::uint32_t end) const {
    const glm::dvec2& p = place(hole);
    const glm::dvec2& far = place(end);
    std::uint32_t best = end;
    const double steep = slope(p, far);
    const std::size_t last = row_of(std::max(p.y, far.y));
    for (std::size_t row = row_of(std::min(p.y, far.y)); row <= last; ++row) {
      for (const std::uint32_t n : rows_[row]) {
        if (n == best || !loops_[loop_of_[n]].joined) continue;
        const glm::dvec2& q = place(n);
        if (q.y < std::min(p.y, far.y) || q.y > std::max(p.y, far.y) || q.x > p.x || q.x < far.x) continue;
        if (slope(p, q) > steep) continue;
        if (q != far && !is_right_of(seen, far, q)) continue;
        if (is_better(p, q, n, best, hole)) best = n;
      }
    }
    return best;
  }

  [[nodiscard]] static double slope(const glm::dvec2& p, const glm::dvec2& q) {
    if (p == q) return -1;
    return p.x > q.x ? std::abs(q.y - p.y) / (p.x - q.x) : std::numeric_limits<double>::infinity();
  }

  // Returns whether q is on the hole's side of the edge from `seen` to `far`, or on it.
  [[nodiscard]] static bool is_right_of(const glm::dvec2& seen, const glm::dvec2& far, const glm::dvec2& q) {
    if (far.y == seen.y) return true;
    return q.x >= seen.x + (q.y - seen.y) * ((far.x - seen.x) / (far.y - seen.y));
  }

  [[nodiscard]] bool is_better(const glm::dvec2& p, const glm::dvec2& q, std::uint32_t n, std::uint32_t best,
                               std::uint32_t hole) const {
    const glm::dvec2& old = place(best);
    if (q == old) return faces(n, hole) > faces(best, hole);
    const double slope_new = slope(p, q);
    const double slope_old = slope(p, old);
    if (slope_new != slope_old) return slope_new < slope_old;
    return q.x > old.x;
  }

  // Rates how the corner at node n opens towards the hole's first node: 2 inside, 1 along an edge, 0 not.
  [[nodiscard]] int faces(std::uint32_t n, std::uint32_t hole) const {
    const glm::dvec2& at = place(n);
    const glm::dvec2 before = place(other_place(n, false));
    const glm::dvec2 after = place(other_place(n, true));
    glm::dvec2 to = place(hole);
    if (to == at) to = place(other_place(hole, true));
    const int from_before = mesh::orientation_2d(before, at, to);
    const int from_after = mesh::orientation_2d(at, after, to);
    const bool convex = mesh::orientation_2d(before, at, after) > 0;
    const int both = std::min(from_before, from_after);
    const int either = std::max(from_before, from_after);
    return (convex ? both : either) + 1;
  }

  // Returns the next or previous node at another place.
  [[nodiscard]] std::uint32_t other_place(std::uint32_t n, bool forward) const {
    std::uint32_t other = n;
    do {
      other = forward ? result_.nodes[other].next : result_.nodes[other].prev;
    } while (other != n && place(other) == place(n));
    return other;
  }

  // Inserts the bridge. New nodes carry it, so edges listed in rows_ keep their nodes.
  void join(std::uint32_t to, std::uint32_t hole) {
    std::vector<PolygonNode>& nodes = result_.nodes;
    const auto there = static_cast<std::uint32_t>(nodes.size());
    const std::uint32_t back = there + 1;
    const std::uint32_t before = nodes[to].prev;
    const std::uint32_t last = nodes[hole].prev;
    nodes.push_back({nodes[to].point, before, hole});
    nodes.push_back({nodes[hole].point, last, to});
    nodes[before].next = there;
    nodes[hole].prev = there;
    nodes[last].next = back;
    nodes[to].prev = back;
    loop_of_.insert(loop_of_.end(), 2, loop_of_[to]);
    result_.bridges.emplace_back(there, back);
    list(there);
    list(back);
  }

  std::span<const glm::dvec2> points_;
  BridgedLoops result_;
  std::vector<Loop> loops_;
  std::vector<std::uint32_t> loop_of_;
  std::vector<std::vector<std::uint32_t>> rows_;
  double low_ = 0;
  double height_ = 1;
};

}  // namespace

BridgedLoops bridge_holes(std::span<const glm::dvec2> points, std::span<const std::uint32_t> next) {
  return HoleBridges(points, next).run();
}

}  // namespace isoextract::edit

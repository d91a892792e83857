#include "edit/detail/polygon_ears.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>

#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kNoCorner = std::numeric_limits<std::uint32_t>::max();

// Kinds of ears, in order of preference.
enum class EarKind {
  clear,     // no node lies on the edge that cuts it off
  touching,  // nodes may touch that edge
  flat,      // zero area
  rough,     // overlaps the rest by rounding at most
  any        // overlaps the rest
};

// The nodes of a polygon, sorted into square cells.
class NodeGrid {
 public:
  void build(std::span<const glm::dvec2> places, std::span<const std::uint32_t> nodes) {
    low_ = glm::dvec2(std::numeric_limits<double>::infinity());
    glm::dvec2 high = -low_;
    for (const std::uint32_t n : nodes) {
      low_ = glm::min(low_, places[n]);
      high = glm::max(high, places[n]);
    }
    const glm::dvec2 size = high - low_;
    // About one node a cell where nodes lie along lines.
    const double count = static_cast<double>(nodes.size());
    cell_ = std::max({std::sqrt(size.x * size.y / count), size.x / count, size.y / count});
    if (!(cell_ > 0)) cell_ = 1;
    cells_ = {cell_of(high.x - low_.x, kMost) + 1, cell_of(high.y - low_.y, kMost) + 1};
    starts_.assign(std::size_t{cells_.x} * cells_.y + 1, 0);
    const auto index_of = [&](std::uint32_t n) {
      const glm::uvec2 cell = cell_at(places[n]);
      return std::size_t{cell.y} * cells_.x + cell.x;
    };
    for (const std::uint32_t n : nodes) ++starts_[index_of(n) + 1];
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    listed_.resize(nodes.size());
    std::vector<std::uint32_t> at(starts_.begin(), starts_.end() - 1);
    for (const std::uint32_t n : nodes) listed_[at[index_of(n)]++] = n;
  }

  // Returns the first node in the box for which `is_it` holds, or kNoCorner.
  template <class Test>
  [[nodiscard]] std::uint32_t find(const glm::dvec2& low, const glm::dvec2& high, const Test& is_it) const {
    const glm::uvec2 from = cell_at(low);
    const glm::uvec2 to = cell_at(high);
    for (std::uint32_t y = from.y; y <= to.y; ++y) {
      const std::size_t row = std::size_t{y} * cells_.x;
      for (std::uint32_t i = starts_[row + from.x]; i < starts_[row + to.x + 1]; ++i) {
        if (is_it(listed_[i])) return listed_[i];
      }
    }
    return kNoCorner;
  }

 private:
  static constexpr std::uint32_t kMost = 1U << 20;

  [[nodiscard]] std::uint32_t cell_of(double along, std::uint32_t last) const {
    return static_cast<std::uint32_t>(std::clamp(along / cell_, 0.0, static_cast<double>(last)));
  }
  [[nodiscard]] glm::uvec2 cell_at(const glm::dvec2& p) const {
    return {cell_of(p.x - low_.x, cells_.x - 1), cell_of(p.y - low_.y, cells_.y - 1)};
  }

  glm::dvec2 low_{0};
  double cell_ = 1;
  glm::uvec2 cells_{1};
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> listed_;
};

class EarCutter {
 public:
  EarCutter(std::span<const glm::dvec2> points, std::span<const PolygonNode> nodes, std::uint32_t first, Ears& ears,
            double rounding)
      : points_(points), ears_(ears), rounding_(rounding) {
    // Numbers the polygon's nodes from 0, so that a small polygon among many takes little memory.
    std::uint32_t n = first;
    do {
      ring_.push_back({nodes[n].point, 0, 0});
      facts_.emplace_back().node = n;
      n = nodes[n].next;
    } while (n != first);
    const auto count = static_cast<std::uint32_t>(ring_.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      ring_[i].prev = i == 0 ? count - 1 : i - 1;
      ring_[i].next = i + 1 == count ? 0 : i + 1;
      places_.push_back(points_[ring_[i].point]);
    }
    left_ = count;
    rebuild();
  }

  bool run() {
    std::uint32_t at = 0;
    folds_.resize(left_);
    std::iota(folds_.rbegin(), folds_.rend(), std::uint32_t{0});
    while (true) {
      cut_folds();
      while (facts_[at].gone) at = ring_[at].next;
      if (left_ <= 3) return put(at);
      std::uint32_t ear = kNoCorner;
      for (const EarKind kind : {EarKind::clear, EarKind::touching, EarKind::flat, EarKind::rough, EarKind::any}) {
        ear = find_ear(at, kind);
        if (ear != kNoCorner) break;
      }
      if (ear == kNoCorner) return false;
      // Continues beyond the neighbor, so that ears are cut all around instead of in a fan.
      at = ring_[ring_[ear].next].next;
      cut(ear);
      if (left_ * 2 < listed_) rebuild();
    }
  }

 private:
  // Cached facts about a node, valid until it or its blocker changes.
  struct NodeFacts {
    std::uint32_t version = 0;
    std::uint32_t blocker = kNoCorner;
    std::uint32_t blocker_version = 0;
    std::uint32_t own_version = 0;
    EarKind kind = EarKind::clear;
    bool gone = false;
    std::uint32_t node = kNoCorner;
    HalfEdge beyond = kNoHalfEdge;  // half-edge of the ear cut off between this node and the next, if any
  };

  void rebuild() {
    std::vector<std::uint32_t> nodes;
    for (std::uint32_t n = 0; n < ring_.size(); ++n) {
      if (!facts_[n].gone) nodes.push_back(n);
    }
    listed_ = nodes.size();
    grid_.build(places_, nodes);
  }

  [[nodiscard]] std::uint32_t find_ear(std::uint32_t from, EarKind kind) {
    std::uint32_t n = from;
    for (std::size_t i = 0; i < left_; ++i, n = ring_[n].next) {
      if (is_ear(n, kind)) return n;
    }
    return kNoCorner;
  }

  [[nodiscard]] bool is_ear(std::uint32_t n, EarKind kind) {
    const std::uint32_t before = ring_[n].prev;
    const std::uint32_t after = ring_[n].next;
    if (!differ(before, n, after)) return false;
    const glm::dvec2& a = places_[before];
    const glm::dvec2& b = places_[n];
    const glm::dvec2& c = places_[after];
    if (kind == EarKind::any) return true;
    const int turn = mesh::orientation_2d(a, b, c);
    if (kind == EarKind::flat) return turn == 0;
    if (kind == EarKind::rough && turn <= 0) return width_of({a, b, c}) >= -rounding_;
    return turn > 0 && !is_blocked(n, kind);
  }

  // Cuts off folds, where the outline runs back on itself; the remaining shape is the same. Folds go first: the test of
  // an ear's neighborhood is right only where one point of the outline lies at each position.
  void cut_folds() {
    while (!folds_.empty() && left_ > 3) {
      const std::uint32_t n = folds_.back();
      folds_.pop_back();
      if (!facts_[n].gone && is_fold(n)) cut(n);
    }
  }

  [[nodiscard]] bool is_fold(std::uint32_t n) const {
    if (!differ(ring_[n].prev, n, ring_[n].next)) return false;
    const glm::dvec2& a = places_[ring_[n].prev];
    const glm::dvec2& b = places_[n];
    const glm::dvec2& c = places_[ring_[n].next];
    if (a == b || b == c || a == c) return true;
    return glm::dot(a - b, c - b) > 0 && mesh::orientation_2d(a, b, c) == 0;
  }

  [[nodiscard]] bool differ(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    const std::uint32_t p = ring_[a].point;
    const std::uint32_t q = ring_[b].point;
    const std::uint32_t r = ring_[c].point;
    return p != q && q != r && r != p;
  }

  [[nodiscard]] bool is_blocked(std::uint32_t n, EarKind kind) {
    NodeFacts& facts = facts_[n];
    if (facts.blocker != kNoCorner && facts.kind == kind && facts.own_version == facts.version &&
        facts.blocker_version == facts_[facts.blocker].version && !facts_[facts.blocker].gone) {
      return true;
    }
    const std::uint32_t before = ring_[n].prev;
    const std::uint32_t after = ring_[n].next;
    const std::array<glm::dvec2, 3> ear{places_[before], places_[n], places_[after]};
    const glm::dvec2 low = glm::min(glm::min(ear[0], ear[1]), ear[2]);
    const glm::dvec2 high = glm::max(glm::max(ear[0], ear[1]), ear[2]);
    const std::uint32_t blocker = grid_.find(low, high, [&](std::uint32_t q) {
      return q != before && q != n && q != after && !facts_[q].gone && blocks(q, ear, kind);
    });
    facts.blocker = blocker;
    if (blocker == kNoCorner) return false;
    facts.kind = kind;
    facts.own_version = facts.version;
    facts.blocker_version = facts_[blocker].version;
    return true;
  }

  // Returns the width across the longest side; negative if the triangle runs clockwise.
  [[nodiscard]] static double width_of(const std::array<glm::dvec2, 3>& ear) {
    const glm::dvec2 u = ear[1] - ear[0];
    const glm::dvec2 v = ear[2] - ear[0];
    return (u.x * v.y - u.y * v.x) / std::max({glm::length(u), glm::length(v), glm::length(v - u)});
  }

  // Returns whether q lies inside the ear by more than rounding.
  [[nodiscard]] bool is_deep(const glm::dvec2& q, const std::array<glm::dvec2, 3>& ear) const {
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec2 along = ear[(i + 1) % 3] - ear[i];
      const glm::dvec2 to = q - ear[i];
      if (along.x * to.y - along.y * to.x <= rounding_ * glm::length(along)) return false;
    }
    return true;
  }

  // Returns whether node q lies in the ear, or an edge at q enters the ear through the ear's outline.
  [[nodiscard]] bool blocks(std::uint32_t q, const std::array<glm::dvec2, 3>& ear, EarKind kind) const {
    if (kind == EarKind::rough) return is_deep(places_[q], ear);
    std::array<int, 3> side{};  // side of q for each edge of the ear; the last edge is the cut
    for (std::size_t i = 0; i < 3; ++i) {
      side[i] = mesh::orientation_2d(ear[i], ear[(i + 1) % 3], places_[q]);
      if (side[i] < 0) return false;
    }
    if (side[0] > 0 && side[1] > 0 && (side[2] > 0 || kind == EarKind::clear)) return true;
    const auto enters = [&](std::uint32_t end) {
      for (std::size_t i = 0; i < 3; ++i) {
        if (side[i] == 0 && mesh::orientation_2d(ear[i], ear[(i + 1) % 3], places_[end]) <= 0) return false;
      }
      return true;
    };
    return enters(ring_[q].prev) || enters(ring_[q].next);
  }

  bool put(std::uint32_t n) {
    if (!differ(ring_[n].prev, n, ring_[n].next)) return false;
    const HalfEdge last = add(n);
    meet(ring_[n].next, last);
    return true;
  }

  // Adds the triangle at n. Returns its half-edge from the next node to the previous one.
  HalfEdge add(std::uint32_t n) {
    const auto h = static_cast<HalfEdge>(3 * ears_.triangles.size());
    const std::uint32_t before = ring_[n].prev;
    ears_.triangles.emplace_back(ring_[before].point, ring_[n].point, ring_[ring_[n].next].point);
    ears_.twins.insert(ears_.twins.end(), 3, kNoHalfEdge);
    meet(before, h);
    meet(n, h + 1);
    return h + 2;
  }

  // Connects half-edge h, which runs from node n to the next.
  void meet(std::uint32_t n, HalfEdge h) {
    const HalfEdge beyond = facts_[n].beyond;
    if (beyond == kNoHalfEdge) {
      ears_.of_node[facts_[n].node] = h;
    } else {
      ears_.twins[h] = beyond;
      ears_.twins[beyond] = h;
    }
  }

  void cut(std::uint32_t n) {
    const std::uint32_t before = ring_[n].prev;
    facts_[before].beyond = add(n);
    const std::uint32_t after = ring_[n].next;
    ring_[before].next = after;
    ring_[after].prev = before;
    ++facts_[before].version;
    ++facts_[after].version;
    facts_[n].gone = true;
    --left_;
    folds_.push_back(after);
    folds_.push_back(before);
  }

  std::span<const glm::dvec2> points_;
  Ears& ears_;
  std::vector<PolygonNode> ring_;
  std::vector<glm::dvec2> places_;
  std::vector<NodeFacts> facts_;
  NodeGrid grid_;
  std::vector<std::uint32_t> folds_;  // candidates for folds
  double rounding_;
  std::size_t left_ = 0;
  std::size_t listed_ = 0;
};

}  // namespace

bool clip_ears(std::span<const glm::dvec2> points, std::span<const PolygonNode> nodes, std::uint32_t first, Ears& ears,
               double rounding) {
  return EarCutter(points, nodes, first, ears, rounding).run();
}

}  // namespace isoextract::edit

#include "edit/detail/pinch_points.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

// An edge at a place, seen from the place.
struct Spoke {
  glm::dvec2 end;
  bool leaves;
  std::uint32_t node;  // the last of consecutive nodes of a loop at this place
};

class PinchPointSplitter {
 public:
  PinchPointSplitter(std::span<const glm::dvec2> points, BridgedLoops& loops)
      : points_(points), nodes_(loops.nodes), loops_(loops) {}

  void run() {
    std::vector<std::uint32_t> order(nodes_.size());
    std::iota(order.begin(), order.end(), std::uint32_t{0});
    std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
      const glm::dvec2& p = place(a);
      const glm::dvec2& q = place(b);
      return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : a < b;
    });
    for (std::size_t i = 0, j = 0; i < order.size(); i = j) {
      while (j < order.size() && place(order[j]) == place(order[i])) ++j;
      if (j - i > 1) cut_at(std::span(order).subspan(i, j - i));
    }
  }

 private:
  [[nodiscard]] const glm::dvec2& place(std::uint32_t node) const { return points_[nodes_[node].point]; }

  void cut_at(std::span<const std::uint32_t> here) {
    const glm::dvec2 at = place(here[0]);
    spokes_.clear();
    for (const std::uint32_t n : here) {
      if (place(nodes_[n].next) == at) continue;
      std::uint32_t first = n;
      while (place(nodes_[first].prev) == at) first = nodes_[first].prev;
      spokes_.push_back({place(nodes_[n].next), true, n});
      spokes_.push_back({place(nodes_[first].prev), false, n});
    }
    if (spokes_.size() < 4) return;
    sort_around(at);
    if (!alternate(at, false) && !alternate(at, true)) return;
    // Counter-clockwise, each filled sector begins at a leaving edge and ends at the next one, which enters.
    const std::size_t count = around_.size();
    std::vector<std::pair<std::uint32_t, std::uint32_t>> goes_on;  // entering node, node whose edge follows
    for (std::size_t i = 0; i < count; ++i) {
      if (!around_[i].leaves) goes_on.emplace_back(around_[i].node, around_[(i + count - 1) % count].node);
    }
    link(goes_on);
  }

  void sort_around(const glm::dvec2& at) {
    const auto is_upper = [&](const Spoke& s) { return s.end.y != at.y ? s.end.y > at.y : s.end.x > at.x; };
    std::ranges::sort(spokes_, [&](const Spoke& a, const Spoke& b) {
      if (is_upper(a) != is_upper(b)) return is_upper(a);
      const int turn = mesh::orientation_2d(at, a.end, b.end);
      return turn != 0 ? turn > 0 : a.node < b.node;
    });
  }

  // Orders the edges around the place so that leaving and entering edges alternate; edges in one direction are swapped
  // as needed. Returns false if that is impossible.
  bool alternate(const glm::dvec2& at, bool filled) {
    around_.clear();
    bool inside = filled;
    std::vector<Spoke> left;
    for (std::size_t i = 0, j = 0; i < spokes_.size(); i = j) {
      const auto same = [&](const Spoke& a, const Spoke& b) {
        return mesh::orientation_2d(at, a.end, b.end) == 0 && glm::dot(a.end - at, b.end - at) > 0;
      };
      while (j < spokes_.size() && same(spokes_[i], spokes_[j])) ++j;
      left.assign(spokes_.begin() + static_cast<std::ptrdiff_t>(i), spokes_.begin() + static_cast<std::ptrdiff_t>(j));
      while (!left.empty()) {
        const auto fits = std::ranges::find(left, !inside, &Spoke::leaves);
        if (fits == left.end()) return false;
        around_.push_back(*fits);
        left.erase(fits);
        inside = !inside;
      }
    }
    return inside == filled;
  }

  void link(std::vector<std::pair<std::uint32_t, std::uint32_t>>& goes_on) {
    std::ranges::sort(goes_on);
    std::vector<PolygonNode> old;
    for (const auto& [node, by] : goes_on) old.push_back(nodes_[by]);
    const auto index_of = [&](std::uint32_t node) {
      const auto found = std::ranges::lower_bound(goes_on, std::pair(node, std::uint32_t{0}));
      return static_cast<std::size_t>(found - goes_on.begin());
    };
    for (std::size_t i = 0; i < goes_on.size(); ++i) {
      const auto [node, by] = goes_on[i];
      if (node == by) continue;
      const auto made = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back({old[i].point, node, old[i].next});
      nodes_[old[i].next].prev = made;
      nodes_[node].next = made;
    }
    // Zero-length edges join the nodes: two form one bridge, three or more bound a polygon without area.
    std::vector<bool> done(goes_on.size());
    for (std::size_t i = 0; i < goes_on.size(); ++i) {
      if (done[i] || goes_on[i].first == goes_on[i].second) continue;
      std::vector<std::uint32_t> cycle;
      for (std::size_t k = i; !done[k]; k = index_of(goes_on[k].second)) {
        done[k] = true;
        cycle.push_back(goes_on[k].first);
      }
      if (cycle.size() == 2) {
        loops_.bridges.emplace_back(cycle[0], cycle[1]);
        continue;
      }
      const auto first = static_cast<std::uint32_t>(nodes_.size());
      const auto count = static_cast<std::uint32_t>(cycle.size());
      for (std::uint32_t k = 0; k < count; ++k) {
        // From the node after cycle[k] back to cycle[k].
        nodes_.push_back(
            {nodes_[cycle[(k + 1) % count]].point, first + (k + 1) % count, first + (k + count - 1) % count});
        loops_.bridges.emplace_back(cycle[k], first + k);
      }
    }
  }

  std::span<const glm::dvec2> points_;
  std::vector<PolygonNode>& nodes_;
  BridgedLoops& loops_;
  std::vector<Spoke> spokes_;
  std::vector<Spoke> around_;
};

}  // namespace

void split_at_pinch_points(std::span<const glm::dvec2> points, BridgedLoops& loops) {
  PinchPointSplitter(points, loops).run();
}

}  // namespace isoextract::edit

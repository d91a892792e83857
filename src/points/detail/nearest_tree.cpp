#include "points/detail/nearest_tree.hpp"

#include <algorithm>
#include <bit>

#include <fmt/format.h>
#include <tbb/parallel_invoke.h>

#include "base/finite.hpp"

namespace isoextract::points {
namespace {

constexpr std::uint32_t kLeaf = 12;         // most points in a leaf, unless all coincide
constexpr std::uint32_t kOneThread = 8192;  // smaller subtrees are built without another thread

double squared_distance_to_box(const glm::dvec3& p, const glm::dvec3& low, const glm::dvec3& high) {
  const glm::dvec3 away = glm::max(glm::max(low - p, p - high), glm::dvec3(0));
  return glm::dot(away, away);
}

}  // namespace

Result<NearestTree> NearestTree::make(std::span<const glm::dvec3> points, const Context& context,
                                      const std::string& label) {
  std::size_t count = 0;
  for (const glm::dvec3& p : points) count += static_cast<std::size_t>(is_finite(p));
  // Allocates the nodes of a complete binary tree whose leaves have at most kLeaf points.
  const std::size_t nodes = 2 * std::bit_ceil(count / kLeaf + 1);
  auto memory = TRY(context.reserve(count * sizeof(std::uint32_t) + nodes * sizeof(Node),
                                    fmt::format("{}: the nearest of {} particles", label, count)));
  NearestTree tree;
  tree.memory_ = std::move(memory);
  tree.points_ = points;
  tree.order_ = Buffer<std::uint32_t>(count);
  tree.nodes_ = Buffer<Node>(nodes);
  std::size_t n = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_finite(points[i])) tree.order_[n++] = static_cast<std::uint32_t>(i);
  }
  TRY(context.check());
  tree.build(0, 0, static_cast<std::uint32_t>(count));
  return tree;
}

void NearestTree::build(std::size_t node, std::uint32_t first, std::uint32_t last) {
  Node& box = nodes_[node];
  box = {glm::dvec3(std::numeric_limits<double>::infinity()), glm::dvec3(-std::numeric_limits<double>::infinity()),
         first, last, true};
  for (std::uint32_t k = first; k < last; ++k) {
    box.low = glm::min(box.low, points_[order_[k]]);
    box.high = glm::max(box.high, points_[order_[k]]);
  }
  if (last - first <= kLeaf || box.low == box.high) return;
  box.leaf = false;
  const glm::dvec3 size = box.high / 2.0 - box.low / 2.0;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return points_[a][axis] != points_[b][axis] ? points_[a][axis] < points_[b][axis] : a < b;
                   });
  const auto lower = [&] { build(2 * node + 1, first, middle); };
  const auto upper = [&] { build(2 * node + 2, middle, last); };
  if (last - first < kOneThread) {
    lower();
    upper();
  } else {
    tbb::parallel_invoke(lower, upper);
  }
}

NearestTree::Found NearestTree::nearest(const glm::dvec3& p) const {
  Found found;
  if (!order_.empty()) search(0, p, found);
  return found;
}

void NearestTree::search(std::size_t node, const glm::dvec3& p, Found& found) const {
  const Node& box = nodes_[node];
  if (box.leaf) {
    for (std::uint32_t k = box.first; k < box.last; ++k) {
      const glm::dvec3& q = points_[order_[k]];
      const glm::dvec3 away = q - p;
      const double squared = glm::dot(away, away);
      if (squared < found.squared_distance || (squared == found.squared_distance && order_[k] < found.point)) {
        found = {squared, order_[k]};
      }
    }
    return;
  }
  visit_children(
      node, p, [&] { return found.squared_distance; }, [&](std::size_t child) { search(child, p, found); });
}

double NearestTree::squared_distance_to_bounds(const glm::dvec3& p) const {
  return order_.empty() ? std::numeric_limits<double>::infinity()
                        : squared_distance_to_box(p, nodes_[0].low, nodes_[0].high);
}

void NearestTree::nearest_positions(const glm::dvec3& p, std::size_t count, std::vector<Found>& found) const {
  found.clear();
  if (!order_.empty() && count > 0) search_positions(0, p, count, found);
}

void NearestTree::search_positions(std::size_t node, const glm::dvec3& p, std::size_t count,
                                   std::vector<Found>& found) const {
  const Node& box = nodes_[node];
  const bool coincide = box.low == box.high;
  if (coincide && box.low == p) return;
  if (box.leaf) {
    const std::uint32_t last = coincide ? box.first + 1 : box.last;
    for (std::uint32_t k = box.first; k < last; ++k) {
      const glm::dvec3& q = points_[order_[k]];
      const glm::dvec3 away = q - p;
      const Found candidate{glm::dot(away, away), order_[k]};
      if (q == p || (found.size() == count && candidate.squared_distance >= found.back().squared_distance)) continue;
      auto at = std::ranges::upper_bound(found, candidate.squared_distance, {}, &Found::squared_distance);
      bool known = false;
      for (auto same = at; same != found.begin() && (--same)->squared_distance == candidate.squared_distance;) {
        known = known || points_[same->point] == q;
      }
      if (known) continue;
      if (found.size() == count) found.pop_back();
      found.insert(at, candidate);
    }
    return;
  }
  const auto reach = [&] {
    return found.size() < count ? std::numeric_limits<double>::infinity() : found.back().squared_distance;
  };
  visit_children(node, p, reach, [&](std::size_t child) { search_positions(child, p, count, found); });
}

template <class Reach, class Visit>
void NearestTree::visit_children(std::size_t node, const glm::dvec3& p, const Reach& reach, const Visit& visit) const {
  std::size_t near = 2 * node + 1;
  std::size_t far = near + 1;
  double near_distance = squared_distance_to_box(p, nodes_[near].low, nodes_[near].high);
  double far_distance = squared_distance_to_box(p, nodes_[far].low, nodes_[far].high);
  if (far_distance < near_distance) {
    std::swap(near, far);
    std::swap(near_distance, far_distance);
  }
  if (near_distance <= reach()) visit(near);
  if (far_distance <= reach()) visit(far);
}

}  // namespace isoextract::points

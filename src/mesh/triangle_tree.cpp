#include "mesh/triangle_tree.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "base/parallel.hpp"
#include "mesh/closest_point.hpp"
#include "mesh/detail/box_filter.hpp"

namespace isoextract::mesh {
namespace {

constexpr double kAxisOne = 32767;
constexpr double kSlabRounding = 1e-12;  // relative to the coordinates; more than double arithmetic causes

BoxTree tree_of(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  Buffer<BoxTree::Item> items(triangles.size());
  for_each_index(triangles.size(), [&](std::size_t t) {
    const glm::uvec3& corner = triangles[t];
    // Takes thirds first, because the sum of coordinates could overflow.
    constexpr float kThird = 1.0F / 3;
    items[t] = {positions[corner.x] * kThird + positions[corner.y] * kThird + positions[corner.z] * kThird,
                static_cast<std::uint32_t>(t)};
  });
  return {items.span(), [&](std::uint32_t t) {
            const glm::uvec3& corner = triangles[t];
            return box_around(positions[corner.x], positions[corner.y], positions[corner.z]);
          }};
}

glm::dvec3 closest_of_corners(const TriangleTree::Corners& corners, const glm::dvec3& p) {
  return ClosestPointTriangle(corners.a, corners.b, corners.c).closest(p);
}

}  // namespace

TriangleTree::TriangleTree(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles)
    : tree_(tree_of(positions, triangles)), corners_(triangles.size()) {
  for_each_index(corners_.size(), [&](std::size_t slot) {
    const glm::uvec3& corner = triangles[tree_.numbers()[slot]];
    corners_[slot] = {positions[corner.x], positions[corner.y], positions[corner.z]};
  });
  if (boxes_are_loose()) make_slabs();
}

double TriangleTree::Slab::along(const glm::dvec3& p) const {
  return (axis[0] * p.x + axis[1] * p.y + axis[2] * p.z) / kAxisOne;
}

double TriangleTree::Slab::distance(const glm::dvec3& p) const {
  const double at = along(p);
  const double outside = std::max(static_cast<double>(low) - at, at - static_cast<double>(high));
  const double rounding =
      kSlabRounding * std::max({std::abs(at), std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high))});
  return std::max(outside - rounding, 0.0);
}

// Compares the surface area of the leaves' boxes with the area of the triangles: a box around a patch of a surface has
// a few times the area of the patch.
bool TriangleTree::boxes_are_loose() const {
  constexpr double kTight = 64;
  struct Sums {
    double boxes = 0;
    double triangles = 0;
  };
  const Sums sums = reduce_ranges(
      tree_.leaves(), 1 << 10, Sums{},
      [&](std::size_t first, std::size_t last, Sums sum) {
        for (std::size_t leaf = first; leaf != last; ++leaf) {
          const FloatBox& box = tree_.box(tree_.leaf(leaf).index());
          const glm::dvec3 size = glm::dvec3(box.max) - glm::dvec3(box.min);
          sum.boxes += size.x * size.y + size.y * size.z + size.z * size.x;
        }
        const std::size_t end = tree_.first_slot(tree_.leaf(last));
        for (std::size_t t = tree_.first_slot(tree_.leaf(first)); t < end; ++t) {
          const glm::dvec3 a(corners_[t].a);
          sum.triangles += glm::length(glm::cross(glm::dvec3(corners_[t].b) - a, glm::dvec3(corners_[t].c) - a));
        }
        return sum;
      },
      [](const Sums& a, const Sums& b) {
        return Sums{a.boxes + b.boxes, a.triangles + b.triangles};
      });
  return tree_.leaves() > 1 && sums.boxes > kTight * sums.triangles;
}

void TriangleTree::make_slabs() {
  slabs_ = Buffer<std::array<Slab, 2>>(tree_.leaves() - 1);
  for (std::size_t level = 0; std::size_t{1} << level < tree_.leaves(); ++level) {
    for_each_index(std::size_t{1} << level, [&](std::size_t number) {
      const BoxTree::Node node{level, number};
      slabs_[node.index()] = slabs_of(node);
    });
  }
}

// Returns slabs that measure along the normal of the largest triangle, and across the longest side in that triangle's
// plane.
std::array<TriangleTree::Slab, 2> TriangleTree::slabs_of(const BoxTree::Node& node) const {
  const std::size_t first = tree_.first_slot(node);
  const std::size_t last = tree_.end_slot(node);
  glm::dvec3 normal(0);
  glm::dvec3 side(0);
  for (std::size_t t = first; t < last; ++t) {
    const glm::dvec3 a(corners_[t].a);
    const glm::dvec3 b(corners_[t].b);
    const glm::dvec3 c(corners_[t].c);
    const glm::dvec3 across = glm::cross(b - a, c - a);
    if (glm::dot(across, across) > glm::dot(normal, normal)) normal = across;
    for (const glm::dvec3& way : {b - a, c - b, a - c}) {
      if (glm::dot(way, way) > glm::dot(side, side)) side = way;
    }
  }
  const std::array axes{normal, glm::cross(normal, side)};
  std::array<Slab, 2> slabs;
  for (std::size_t i = 0; i < slabs.size(); ++i) {
    Slab& slab = slabs[i];
    const double length = glm::length(axes[i]);
    if (!(length > 0) || !std::isfinite(length)) continue;  // then the slab contains all points
    for (int axis = 0; axis < 3; ++axis) {
      slab.axis[static_cast<std::size_t>(axis)] =
          static_cast<std::int16_t>(std::lround((kAxisOne - 1) * (axes[i][axis] / length)));
    }
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (std::size_t t = first; t < last; ++t) {
      for (const glm::vec3& corner : {corners_[t].a, corners_[t].b, corners_[t].c}) {
        const double at = slab.along(glm::dvec3(corner));
        low = std::min(low, at);
        high = std::max(high, at);
      }
    }
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    slab.low = std::nextafter(static_cast<float>(low), -kInfinity);
    slab.high = std::nextafter(static_cast<float>(high), kInfinity);
  }
  return slabs;
}

double TriangleTree::bound_squared(std::size_t node, const BoxFilter& filter, const glm::dvec3& p) const {
  const double by_box = filter.bound(tree_.box(node));
  if (node >= slabs_.size()) return by_box;
  const double across = std::max(slabs_[node][0].distance(p), slabs_[node][1].distance(p));
  return std::max(by_box, across * across);
}

std::size_t TriangleTree::count_leaves_within(const glm::dvec3& p, double squared) const {
  const std::size_t first_leaf = tree_.leaves() - 1;
  std::size_t leaves = 0;
  std::vector<std::size_t> waiting{0};
  const BoxFilter filter(p);
  while (!waiting.empty()) {
    const std::size_t node = waiting.back();
    waiting.pop_back();
    if (bound_squared(node, filter, p) > squared) continue;
    if (node >= first_leaf) {
      ++leaves;
    } else {
      waiting.insert(waiting.end(), {2 * node + 1, 2 * node + 2});
    }
  }
  return leaves;
}

TriangleTree::Nearest TriangleTree::nearest_on_triangle(std::uint32_t slot, const glm::dvec3& p) const {
  Nearest found;
  found.slot = slot;
  found.point = closest_of_corners(corners_[slot], p);
  const glm::dvec3 way = p - found.point;
  found.distance_squared = glm::dot(way, way);
  return found;
}

double TriangleTree::max_distance_squared(std::uint32_t slot, std::span<const glm::dvec3> points,
                                          double enough_squared) const {
  const Corners& corners = corners_[slot];
  const ClosestPointTriangle triangle(corners.a, corners.b, corners.c);
  double farthest = 0;
  for (const glm::dvec3& p : points) {
    farthest = std::max(farthest, triangle.distance_squared(p));
    if (farthest > enough_squared) break;
  }
  return farthest;
}

void TriangleTree::search(std::size_t leaf, const BoxFilter& filter, const glm::dvec3& p, std::size_t known,
                          Nearest& best) const {
  const std::size_t last = tree_.end_slot(tree_.leaf(leaf));
  for (std::size_t slot = tree_.first_slot(tree_.leaf(leaf)); slot < last; ++slot) {
    if (slot == known || !(filter.bound_of_triangle(&corners_[slot].a) < best.distance_squared)) continue;
    const glm::dvec3 point = closest_of_corners(corners_[slot], p);
    const glm::dvec3 way = p - point;
    const double squared = glm::dot(way, way);
    if (squared < best.distance_squared) best = {squared, static_cast<std::uint32_t>(slot), point};
  }
}

// Searches below a node whose box may contain a closer point, the nearer child first.
void TriangleTree::search_below(std::size_t node, double node_distance_squared, const BoxFilter& filter,
                                const glm::dvec3& p, double enough_squared, Nearest& best) const {
  struct Entry {
    std::size_t node;
    double distance_squared;
  };
  constexpr std::size_t kMostLevels = 32;  // slots have 32 bits
  std::array<Entry, kMostLevels + 1> waiting;
  std::size_t count = 0;
  const std::size_t first_leaf = tree_.leaves() - 1;
  Entry entry{node, node_distance_squared};
  for (;;) {
    if (best.distance_squared <= enough_squared) return;
    if (entry.distance_squared < best.distance_squared) {
      if (entry.node < first_leaf) {
        Entry near{2 * entry.node + 1, bound_squared(2 * entry.node + 1, filter, p)};
        Entry far{2 * entry.node + 2, bound_squared(2 * entry.node + 2, filter, p)};
        if (far.distance_squared < near.distance_squared) std::swap(near, far);
        if (far.distance_squared < best.distance_squared) waiting[count++] = far;
        entry = near;
        continue;
      }
      search(entry.node - first_leaf, filter, p, tree_.numbers().size(), best);
    }
    if (count == 0) return;
    entry = waiting[--count];
  }
}

// Searches from the leaf of the hint upwards. Siblings on the way are mostly too far to be searched.
TriangleTree::Nearest TriangleTree::nearest(const glm::dvec3& p, std::uint32_t hint, double enough_squared) const {
  Nearest best = nearest_on_triangle(hint, p);
  if (best.distance_squared <= enough_squared) return best;
  const std::size_t leaf = tree_.leaf_of(hint);
  std::size_t node = tree_.leaf(leaf).index();
  const BoxFilter filter(p);
  search(leaf, filter, p, hint, best);
  for (; node > 0 && best.distance_squared > enough_squared; node = (node - 1) / 2) {
    const std::size_t sibling = ((node - 1) ^ 1U) + 1;
    const double squared = bound_squared(sibling, filter, p);
    if (squared < best.distance_squared) search_below(sibling, squared, filter, p, enough_squared, best);
  }
  return best;
}

}  // namespace isoextract::mesh

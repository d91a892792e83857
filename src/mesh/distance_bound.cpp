#include "mesh/distance_bound.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

namespace isoextract::mesh {
namespace {

// A convex polygon in space.
struct Polygon {
  // From this number of corners on, polygons are halved along a diagonal before they are cut.
  static constexpr std::size_t kManyCorners = 8;
  // A cut of a smaller polygon adds one corner, and at most one more per side where rounding bends the sides.
  static constexpr std::size_t kMostCorners = 2 * kManyCorners;

  std::array<glm::dvec3, kMostCorners> corners;
  std::size_t count = 0;
  std::uint32_t hint = 0;

  Polygon() {}  // NOLINT(*-member-init,*-use-equals-default): leaves the corners unset, which would take time
  // Copies only the corners that are set.
  Polygon(const Polygon& other) : count(other.count), hint(other.hint) {  // NOLINT(*-member-init)
    std::copy_n(other.corners.begin(), count, corners.begin());
  }
  Polygon& operator=(const Polygon&) = delete;
  ~Polygon() = default;

  [[nodiscard]] std::span<const glm::dvec3> points() const { return {corners.data(), count}; }
  void add(const glm::dvec3& corner) { corners[count++] = corner; }
  [[nodiscard]] glm::dvec3 center() const {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < count; ++i) sum += corners[i];
    return sum / static_cast<double>(count);
  }
};

struct Plane {
  glm::dvec3 point;
  glm::dvec3 normal;
  [[nodiscard]] double side(const glm::dvec3& p) const { return glm::dot(p - point, normal); }
};

// Returns how far beyond the sides of a triangle the polygon may reach and probably be within a distance of it. Sharp
// corners need the rest of that distance.
double margin_within(double distance, const Polygon& polygon, const TriangleTree::Corners& triangle) {
  constexpr double kOfRest = 0.5;
  const glm::dvec3 a(triangle.a);
  const glm::dvec3 normal = glm::cross(glm::dvec3(triangle.b) - a, glm::dvec3(triangle.c) - a);
  const double length_squared = glm::dot(normal, normal);
  if (!(length_squared > 0)) return 0;
  double height = 0;  // above the triangle's plane, times the length of the normal
  for (const glm::dvec3& corner : polygon.points()) height = std::max(height, std::abs(glm::dot(corner - a, normal)));
  return kOfRest * std::sqrt(std::max(0.0, distance * distance - height * height / length_squared));
}

// Returns the plane perpendicular to the triangle, and by `margin` outside of it, that cuts off the farthest part of
// the polygon. Returns nullopt if no such plane cuts off more than a sliver.
std::optional<Plane> side_to_cut(const Polygon& polygon, const TriangleTree::Corners& triangle, double margin = 0) {
  const std::array<glm::dvec3, 3> corners{triangle.a, triangle.b, triangle.c};
  const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  // Rounding gives a polygon that lies in the cutting plane some thickness. Cutting it there would never end.
  double coordinate = 0;
  for (const glm::dvec3& corner : polygon.points()) {
    coordinate = std::max({coordinate, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  }
  const double rounding = 64 * std::numeric_limits<double>::epsilon() * coordinate;
  std::optional<Plane> best;
  double farthest = 0;
  for (std::size_t edge = 0; edge < 3; ++edge) {
    const glm::dvec3 outward = glm::cross(corners[(edge + 1) % 3] - corners[edge], normal);
    const double length = glm::length(outward);
    if (!(length > 0)) continue;
    const glm::dvec3 direction = outward / length;
    const Plane plane{corners[edge] + margin * direction, direction};
    double low = 0;
    double high = 0;
    for (std::size_t i = 0; i < polygon.count; ++i) {
      const double side = plane.side(polygon.corners[i]);
      low = std::min(low, side);
      high = std::max(high, side);
    }
    // Cutting off a sliver gains nothing.
    constexpr double kSliver = 1e-3;
    if (std::min(high, -low) > kSliver * (high - low) && high - low > rounding && high > farthest) {
      farthest = high;
      best = plane;
    }
  }
  return best;
}

// Returns the plane through the polygon's center perpendicular to its longest edge.
Plane longest_edge_cut(const Polygon& polygon) {
  glm::dvec3 longest(0.0);
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const glm::dvec3 edge = polygon.corners[(i + 1) % polygon.count] - polygon.corners[i];
    if (glm::dot(edge, edge) > glm::dot(longest, longest)) longest = edge;
  }
  return {polygon.center(), longest};
}

// Returns the corner of the polygon that is farthest from a triangle.
const glm::dvec3& farthest_corner(const Polygon& polygon, const TriangleTree& tree, std::uint32_t slot) {
  std::size_t farthest = 0;
  double most = -1;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const double squared = tree.nearest_on_triangle(slot, polygon.corners[i]).distance_squared;
    if (squared > most) {
      most = squared;
      farthest = i;
    }
  }
  return polygon.corners[farthest];
}

std::array<Polygon, 2> cut(const Polygon& polygon, const Plane& plane) {
  std::array<Polygon, 2> parts;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const glm::dvec3& from = polygon.corners[i];
    const glm::dvec3& to = polygon.corners[(i + 1) % polygon.count];
    const double from_side = plane.side(from);
    const double to_side = plane.side(to);
    if (from_side <= 0) parts[0].add(from);
    if (from_side >= 0) parts[1].add(from);
    if ((from_side < 0 && to_side > 0) || (from_side > 0 && to_side < 0)) {
      const glm::dvec3 crossing = from + from_side / (from_side - to_side) * (to - from);
      parts[0].add(crossing);
      parts[1].add(crossing);
    }
  }
  return parts;
}

// Splits along a diagonal, so that no polygon gets too many corners.
std::array<Polygon, 2> halve_corners(const Polygon& polygon) {
  std::array<Polygon, 2> parts;
  const std::size_t middle = polygon.count / 2;
  for (std::size_t i = 0; i <= middle; ++i) parts[0].add(polygon.corners[i]);
  for (std::size_t i = middle; i < polygon.count; ++i) parts[1].add(polygon.corners[i]);
  parts[1].add(polygon.corners[0]);
  return parts;
}

// Cuts the polygon at `side` if set, else in the middle. Halves a polygon with many corners along a diagonal instead.
std::array<Polygon, 2> cut_at(const Polygon& polygon, const std::optional<Plane>& side) {
  if (polygon.count >= Polygon::kManyCorners) return halve_corners(polygon);
  return cut(polygon, side ? *side : longest_edge_cut(polygon));
}

}  // namespace

TriangleBound bound_distance(const std::array<glm::dvec3, 3>& corners, const TriangleTree& tree,
                             const DistanceLimits& limits, double known, std::uint32_t hint,
                             std::span<const std::uint32_t> others) {
  TriangleBound bound;
  double lower = known;
  std::size_t leaves = 0;
  constexpr std::size_t kMostlyEnough = 16;  // polygons
  std::vector<Polygon> waiting;
  waiting.reserve(kMostlyEnough);
  waiting.emplace_back();
  for (const glm::dvec3& corner : corners) waiting[0].add(corner);
  waiting[0].hint = hint;
  const auto add = [&](const Polygon& part, std::uint32_t near) {
    if (part.count < 3) return;
    waiting.push_back(part);
    waiting.back().hint = near;
  };
  const auto add_parts = [&](const std::array<Polygon, 2>& cut_parts, std::uint32_t near) {
    for (const Polygon& part : cut_parts) add(part, near);
  };
  // Returns whether all of the polygon is within limits.enough of the triangle in `slot`; if so, raises bound.upper.
  const double enough_squared = limits.enough * limits.enough;
  const double refuse_squared = limits.refuse * limits.refuse;
  const auto is_accepted = [&](const Polygon& polygon, std::uint32_t slot) {
    const double to_slot = tree.max_distance_squared(slot, polygon.points(), enough_squared);
    if (!(to_slot <= enough_squared)) return false;
    bound.upper = std::max(bound.upper, std::sqrt(to_slot));
    return true;
  };
  // Cuts off what reaches far beyond the sides of the triangle in `slot`; accepts the rest or adds it to the waiting
  // polygons. Returns false if there is nothing to cut off.
  const auto cut_around = [&](const Polygon& polygon, std::uint32_t slot) {
    const TriangleTree::Corners& triangle = tree.corners(slot);
    const double margin = margin_within(limits.enough, polygon, triangle);
    std::optional<Polygon> inner(polygon);
    bool cuts = false;
    while (margin > 0 && inner->count < Polygon::kManyCorners) {
      const auto side = side_to_cut(*inner, triangle, margin);
      if (!side) break;
      cuts = true;
      const std::array<Polygon, 2> sides = cut(*inner, *side);
      add(sides[1], slot);
      if (sides[0].count < 3 || is_accepted(sides[0], slot)) return true;
      inner.emplace(sides[0]);
    }
    if (cuts) add(*inner, slot);
    return cuts;
  };
  for (std::size_t parts = 0; !waiting.empty(); ++parts) {
    const Polygon polygon = waiting.back();
    waiting.pop_back();
    if (parts == 0 && !others.empty()) {
      bound.slot = hint;
      if (cut_around(polygon, hint)) continue;
    } else if (limits.enough > 0) {
      if (parts == 0) bound.slot = hint;
      if (is_accepted(polygon, polygon.hint)) continue;
      const auto is_near = [&](std::uint32_t slot) { return slot != polygon.hint && is_accepted(polygon, slot); };
      if (std::ranges::any_of(others, is_near)) continue;
    }
    const glm::dvec3 center = polygon.center();
    const TriangleTree::Nearest nearest = tree.nearest(center, polygon.hint);
    const double distance = std::sqrt(nearest.distance_squared);
    if (parts == 0) bound.slot = nearest.slot;
    if (distance > bound.lower) {
      bound.lower = distance;
      bound.place = center;
      bound.nearest = nearest.point;
      lower = std::max(lower, distance);
    }
    const double to_triangle = std::sqrt(tree.max_distance_squared(nearest.slot, polygon.points()));
    double radius = 0;
    for (std::size_t i = 0; i < polygon.count; ++i) {
      const glm::dvec3 way = polygon.corners[i] - center;
      radius = std::max(radius, glm::dot(way, way));
    }
    const double upper = std::min(to_triangle, distance + std::sqrt(radius));
    if (upper <= limits.accepted_upper(lower)) {
      bound.upper = std::max(bound.upper, upper);
      continue;
    }
    constexpr std::size_t kLookAgain = 64;  // parts
    if (parts % kLookAgain == kLookAgain - 1 && limits.max_leaves < std::numeric_limits<std::size_t>::max()) {
      leaves += kLookAgain * tree.count_leaves_within(center, nearest.distance_squared);
    }
    const bool too_many = parts + waiting.size() > limits.max_parts || leaves > limits.max_leaves;
    if (lower > limits.refuse || (too_many && std::isfinite(limits.refuse))) {
      bound.upper = std::numeric_limits<double>::infinity();
      bound.unfinished = true;
      return bound;
    }
    if (too_many) {
      bound.upper = std::max(bound.upper, upper);
      bound.unfinished = true;
      continue;
    }
    if (limits.enough > 0 && cut_around(polygon, nearest.slot)) continue;
    const auto side = side_to_cut(polygon, tree.corners(nearest.slot));
    if (!side && std::isfinite(limits.refuse)) {
      const glm::dvec3& corner = farthest_corner(polygon, tree, nearest.slot);
      const TriangleTree::Nearest to_corner = tree.nearest(corner, nearest.slot, refuse_squared);
      if (to_corner.distance_squared > refuse_squared) {
        bound = {std::sqrt(to_corner.distance_squared),
                 std::numeric_limits<double>::infinity(),
                 corner,
                 to_corner.point,
                 bound.slot,
                 true};
        return bound;
      }
    }
    add_parts(cut_at(polygon, side), nearest.slot);
  }
  bound.upper = std::max(bound.upper, bound.lower);
  return bound;
}

}  // namespace isoextract::mesh

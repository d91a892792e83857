#include "edit/detail/surface_cover.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/parallel.hpp"
#include "edit/detail/edge_search.hpp"
#include "mesh/triangle_tree.hpp"

namespace isoextract::edit {
namespace {

constexpr std::uint32_t kNoSlot = std::numeric_limits<std::uint32_t>::max();

// A point over the plane of a triangle: barycentric coordinates of its foot, and its height above the plane.
struct FlatPoint {
  std::array<double, 3> at;
  double height;

  [[nodiscard]] FlatPoint toward(const FlatPoint& other, double part) const {
    const auto between = [&](double a, double b) { return a + part * (b - a); };
    return {{between(at[0], other.at[0]), between(at[1], other.at[1]), between(at[2], other.at[2])},
            between(height, other.height)};
  }
};
using FlatTriangle = std::array<FlatPoint, 3>;

// Barycentric coordinates are below kFar. Parts of the given triangle that are narrower than kRounding, as a fraction
// of it, need not be covered.
constexpr double kFar = 1e4;
constexpr double kRounding = 1e-10;

// The line from p to q.
struct FlatLine {
  // For each corner of the triangle, on which side of the line it is: above 0 on the left, in units of area.
  std::array<double, 3> sides;
  // The side of points that count as points of the line; below 0 if the ends are so close that rounding may turn it.
  double width;

  // The differences round by about 1e-16 of the coordinates, which turns the line by this over its length.
  FlatLine(const FlatPoint& p, const FlatPoint& q) {
    constexpr double kShort = 1e-8;
    const double across = q.at[1] - p.at[1];
    const double up = q.at[2] - p.at[2];
    const double first = p.at[1] * up - p.at[2] * across;
    sides = {first, first - up, first + across};
    const double length = std::abs(across) + std::abs(up);
    const double far = 1 + std::max({p.at[1] * p.at[1], p.at[2] * p.at[2], q.at[1] * q.at[1], q.at[2] * q.at[2]});
    width = length > kShort * far ? kRounding * length : -1;
  }
};

// Returns on which side of the line from p to q the center of the triangle is.
double side_of_center(const FlatPoint& p, const FlatPoint& q) {
  constexpr double kCenter = 1.0 / 3;
  return (p.at[1] - kCenter) * (q.at[2] - kCenter) - (p.at[2] - kCenter) * (q.at[1] - kCenter);
}

// The frame of a triangle.
class TriangleFrame {
 public:
  explicit TriangleFrame(const std::array<glm::dvec3, 3>& triangle) : corners_(triangle) {
    const glm::dvec3 ab = triangle[1] - triangle[0];
    const glm::dvec3 ac = triangle[2] - triangle[0];
    const glm::dvec3 bc = triangle[2] - triangle[1];
    const glm::dvec3 across = glm::cross(ab, ac);
    const double area_squared = glm::dot(across, across);
    const double longest_squared = std::max({glm::dot(ab, ab), glm::dot(ac, ac), glm::dot(bc, bc)});
    constexpr double kThin = 1e-4;
    if (!(area_squared > kThin * kThin * longest_squared * longest_squared)) return;
    is_wide_ = true;
    up_ = across / std::sqrt(area_squared);
    to_b_ = glm::cross(ac, across) / area_squared;
    to_c_ = glm::cross(across, ab) / area_squared;
    highest_ = kFar * std::sqrt(longest_squared);
  }

  [[nodiscard]] bool is_wide() const { return is_wide_; }

  [[nodiscard]] FlatTriangle flat(const mesh::TriangleTree::Corners& t) const {
    return {flat(glm::dvec3(t.a)), flat(glm::dvec3(t.b)), flat(glm::dvec3(t.c))};
  }
  [[nodiscard]] bool is_near(const FlatTriangle& t) const {
    return std::ranges::all_of(t, [&](const FlatPoint& p) {
      return std::max({std::abs(p.at[0]), std::abs(p.at[1]), std::abs(p.at[2])}) < kFar &&
             std::abs(p.height) < highest_;
    });
  }
  [[nodiscard]] glm::dvec3 foot(const FlatPoint& p) const {
    return p.at[0] * corners_[0] + p.at[1] * corners_[1] + p.at[2] * corners_[2];
  }

 private:
  [[nodiscard]] FlatPoint flat(const glm::dvec3& p) const {
    const glm::dvec3 way = p - corners_[0];
    const double b = glm::dot(to_b_, way);
    const double c = glm::dot(to_c_, way);
    return {{1 - b - c, b, c}, glm::dot(up_, way)};
  }

  std::array<glm::dvec3, 3> corners_;
  glm::dvec3 up_{0.0}, to_b_{0.0}, to_c_{0.0};
  double highest_ = 0;
  bool is_wide_ = false;
};

// Returns 1, 2 and 4, added up, for the sides opposite the three corners that the point is not inside of.
unsigned beyond_sides(const FlatPoint& p) {
  return (p.at[0] < kRounding ? 1U : 0U) | (p.at[1] < kRounding ? 2U : 0U) | (p.at[2] < kRounding ? 4U : 0U);
}

// The part of a flat triangle that is over the given one.
class FlatPart {
 public:
  // Clips t at the sides in `sides`, as beyond_sides() numbers them.
  FlatPart(const FlatTriangle& t, unsigned sides) : count_(t.size()) {
    std::ranges::copy(t, corners_.begin());
    for (std::size_t side = 0; side < 3; ++side) {
      if ((sides >> side & 1U) == 0) continue;
      std::array<FlatPoint, kMostCorners> inside;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < count_; ++i) {
        const FlatPoint& from = corners_[i];
        const FlatPoint& to = corners_[i + 1 < count_ ? i + 1 : 0];
        if (from.at[side] >= 0) inside[kept++] = from;
        if ((from.at[side] < 0) == (to.at[side] < 0)) continue;
        inside[kept++] = from.toward(to, from.at[side] / (from.at[side] - to.at[side]));
      }
      std::copy_n(inside.begin(), kept, corners_.begin());
      count_ = kept;
    }
  }

  [[nodiscard]] std::span<const FlatPoint> corners() const { return {corners_.data(), count_}; }

  // Returns the area, as a fraction of that of the given triangle; below 0 if the part faces the other way.
  [[nodiscard]] double area() const {
    double sum = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const FlatPoint& from = corners_[i];
      const FlatPoint& to = corners_[i + 1 < count_ ? i + 1 : 0];
      sum += from.at[1] * to.at[2] - from.at[2] * to.at[1];
    }
    return sum;
  }

 private:
  static constexpr std::size_t kMostCorners = 9;  // each cut adds at most half, however rounding bends the sides
  std::array<FlatPoint, kMostCorners> corners_;
  std::size_t count_;
};

double greatest_height(const FlatTriangle& t) {
  return std::max({std::abs(t[0].height), std::abs(t[1].height), std::abs(t[2].height)});
}

// Returns the greatest height of the plane of t at the corners of the triangle; infinity if t is too narrow to
// extrapolate. `lines` are those of the edges of t.
double greatest_height_of_plane(const FlatTriangle& t, const std::array<FlatLine, 3>& lines, double area) {
  constexpr double kLeastArea = 1e-2;
  if (!(std::abs(area) > kLeastArea)) return std::numeric_limits<double>::infinity();
  double greatest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double height =
        lines[1].sides[i] * t[0].height + lines[2].sides[i] * t[1].height + lines[0].sides[i] * t[2].height;
    greatest = std::max(greatest, std::abs(height));
  }
  return greatest / std::abs(area);
}

}  // namespace

SurfaceCover::SurfaceCover(const SheetTrees& trees, std::span<const std::uint32_t> slots,
                           std::span<const glm::uvec3> triangles, std::size_t vertices, std::span<const char> left_out,
                           const Sheets& sheets)
    : first_(sheets.count) {
  if (triangles.size() >= kNoSlot / 3) return;
  std::uint32_t size = 0;
  for (std::uint32_t sheet = 0; sheet < sheets.count; ++sheet) {
    first_[sheet] = size;
    if (const auto* const tree = trees.find(sheet)) size += static_cast<std::uint32_t>(tree->size());
  }
  neighbors_ = Buffer<std::array<std::uint32_t, 3>>(size);
  const EdgeSearch edges(triangles, vertices, left_out, sheets);
  constexpr std::size_t kGrain = 1 << 10;
  for_each_index(
      static_cast<std::uint32_t>(vertices),
      [&](std::uint32_t vertex) {
        edges.for_each_across(vertex, [&](std::uint32_t t, std::uint32_t corner, std::optional<std::uint32_t> other) {
          neighbors_[first_[sheets.of(t)] + slots[t]][corner] = other ? slots[*other] : kNoSlot;
        });
      },
      kGrain);
}

std::optional<mesh::TriangleBound> SurfaceCover::bound(const std::array<glm::dvec3, 3>& triangle,
                                                       const mesh::TriangleTree& tree, std::uint32_t sheet,
                                                       std::uint32_t slot, double enough) const {
  if (neighbors_.empty()) return std::nullopt;
  const TriangleFrame frame(triangle);
  if (!frame.is_wide()) return std::nullopt;
  constexpr std::size_t kMostTriangles = 128;
  // Fraction of the given triangle. If the triangle over its center is smaller, the cover likely has far too many.
  constexpr double kLeastArea = 1.0 / (4 * kMostTriangles);
  // Walks to the triangle over the center.
  constexpr int kMostSteps = 16;
  FlatTriangle t{};
  for (int step = 0;; ++step) {
    t = frame.flat(tree.corners(slot));
    if (step == kMostSteps || !frame.is_near(t)) return std::nullopt;
    const std::array sides{side_of_center(t[0], t[1]), side_of_center(t[1], t[2]), side_of_center(t[2], t[0])};
    const double area = sides[0] + sides[1] + sides[2];
    if (!(std::abs(area) > kRounding)) return std::nullopt;
    const double orientation = area < 0 ? -1 : 1;
    double least = 0;
    std::size_t across = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      if (orientation * sides[i] >= least) continue;
      least = orientation * sides[i];
      across = i;
    }
    if (across == 3) {
      if (std::abs(area) < kLeastArea) return std::nullopt;
      break;
    }
    slot = neighbors(sheet, slot)[across];
    if (slot == kNoSlot) return std::nullopt;
  }
  struct Farthest {
    double distance = 0;
    glm::dvec3 place{0.0};
  };
  // Returns the foot of the corner that is farthest from the triangle in `near`: one at most `enough` high is as far as
  // it is high.
  const auto farthest_corner = [&](const FlatPart& part, std::uint32_t near) {
    Farthest farthest;
    for (const FlatPoint& corner : part.corners()) {
      double distance = std::abs(corner.height);
      if (!(distance > farthest.distance)) continue;
      const glm::dvec3 foot = frame.foot(corner);
      if (distance > enough) distance = std::sqrt(tree.nearest_on_triangle(near, foot).distance_squared);
      if (distance > farthest.distance) farthest = {distance, foot};
    }
    return farthest;
  };
  // Returns whether triangles of the surface, some of which face the other way, are over each point of the given one.
  // Each edge over it is an edge of two of them. So the number of those that face the same way, less the number of the
  // others, is the same over all its points, and their areas add up to it.
  const auto covers = [&](std::span<const std::uint32_t> triangles) {
    double sum = 0;
    for (const std::uint32_t number : triangles) {
      const FlatTriangle flat = frame.flat(tree.corners(number));
      sum += FlatPart(flat, beyond_sides(flat[0]) | beyond_sides(flat[1]) | beyond_sides(flat[2])).area();
    }
    constexpr double kAlmost = 1e-3;
    const double layers = std::round(sum);
    return layers != 0 && std::abs(sum - layers) < kAlmost;
  };
  mesh::TriangleBound bound;
  bound.slot = slot;
  bool folds = false;
  std::array<std::uint32_t, kMostTriangles> found;
  found[0] = slot;
  std::size_t count = 1;
  for (std::size_t next = 0; next < count; ++next) {
    if (next > 0) t = frame.flat(tree.corners(found[next]));
    if (!frame.is_near(t)) return std::nullopt;
    const std::array beyond{beyond_sides(t[0]), beyond_sides(t[1]), beyond_sides(t[2])};
    if ((beyond[0] & beyond[1] & beyond[2]) != 0) continue;
    const std::array lines{FlatLine(t[0], t[1]), FlatLine(t[1], t[2]), FlatLine(t[2], t[0])};
    const double area = lines[0].sides[0] + lines[1].sides[0] + lines[2].sides[0];
    const double orientation = area < 0 ? -1 : 1;
    std::array<bool, 3> is_met{};  // whether the line through an edge divides the triangle, or may do so
    bool is_apart = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto& [a, b, c] = lines[i].sides;
      const auto [least, most] = std::minmax({orientation * a, orientation * b, orientation * c});
      const double width = lines[i].width;
      is_met[i] = width < 0 || least < -width;
      is_apart |= width >= 0 && most <= width;
    }
    if (is_apart) continue;
    folds |= !(area > kRounding);
    double height = std::min(greatest_height(t), greatest_height_of_plane(t, lines, area));
    if (height > enough) {
      const Farthest farthest = farthest_corner(FlatPart(t, beyond[0] | beyond[1] | beyond[2]), found[next]);
      height = farthest.distance;
      if (height > enough) {
        bound.place = farthest.place;
        const auto nearest = tree.nearest(bound.place, found[next], enough * enough);
        if (nearest.distance_squared <= enough * enough) return std::nullopt;
        bound.lower = std::sqrt(nearest.distance_squared);
        bound.nearest = nearest.point;
        bound.upper = std::numeric_limits<double>::infinity();
        bound.unfinished = true;
        return bound;
      }
    }
    bound.upper = std::max(bound.upper, height);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_met[i] || (beyond[i] & beyond[(i + 1) % 3]) != 0) continue;
      const std::uint32_t other = neighbors(sheet, found[next])[i];
      if (other == kNoSlot) return std::nullopt;
      const auto end = found.begin() + static_cast<std::ptrdiff_t>(count);
      if (std::find(found.begin(), end, other) != end) continue;
      if (count == kMostTriangles) return std::nullopt;
      found[count++] = other;
    }
  }
  if (folds && !covers(std::span(found.data(), count))) return std::nullopt;
  return bound;
}

}  // namespace isoextract::edit

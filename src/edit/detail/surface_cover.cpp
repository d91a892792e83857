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

// Barycentric coordinates below kFar, and products of two, round by less than kRounding.
constexpr double kFar = 1e2;
constexpr double kRounding = 1e-10;

// Returns for each corner of the triangle on which side of the line from p to q it is: above 0 on the left, in units of
// area.
std::array<double, 3> sides_of_line(const FlatPoint& p, const FlatPoint& q) {
  return {p.at[1] * q.at[2] - p.at[2] * q.at[1], p.at[2] * q.at[0] - p.at[0] * q.at[2],
          p.at[0] * q.at[1] - p.at[1] * q.at[0]};
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
    constexpr double kThin = 1e-3;
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

// Returns 1, 2 and 4, added up, for the sides opposite the three corners that the point is outside of.
unsigned outside(const FlatPoint& p) {
  return (p.at[0] < -kRounding ? 1U : 0U) | (p.at[1] < -kRounding ? 2U : 0U) | (p.at[2] < -kRounding ? 4U : 0U);
}

// Returns the point of t over the triangle that is farthest above or below it. Clips t at the sides in `sides`, as
// outside() numbers them.
FlatPoint highest_point(const FlatTriangle& t, unsigned sides) {
  constexpr std::size_t kMostCorners = 9;  // each cut adds at most half, however rounding bends the sides
  std::array<FlatPoint, kMostCorners> part;
  std::size_t count = t.size();
  std::ranges::copy(t, part.begin());
  for (std::size_t side = 0; side < 3; ++side) {
    if ((sides >> side & 1U) == 0) continue;
    std::array<FlatPoint, kMostCorners> inside;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const FlatPoint& from = part[i];
      const FlatPoint& to = part[i + 1 < count ? i + 1 : 0];
      if (from.at[side] >= 0) inside[kept++] = from;
      if ((from.at[side] < 0) == (to.at[side] < 0)) continue;
      inside[kept++] = from.toward(to, from.at[side] / (from.at[side] - to.at[side]));
    }
    std::copy_n(inside.begin(), kept, part.begin());
    count = kept;
  }
  FlatPoint highest{};
  for (std::size_t i = 0; i < count; ++i) {
    if (std::abs(part[i].height) > std::abs(highest.height)) highest = part[i];
  }
  return highest;
}

double greatest_height(const FlatTriangle& t) {
  return std::max({std::abs(t[0].height), std::abs(t[1].height), std::abs(t[2].height)});
}

// Returns the greatest height of the plane of t at the corners of the triangle; infinity if t is too narrow to
// extrapolate. `sides` are of the edges of t.
double greatest_height_of_plane(const FlatTriangle& t, const std::array<std::array<double, 3>, 3>& sides, double area) {
  constexpr double kLeastArea = 1e-2;
  if (!(area > kLeastArea)) return std::numeric_limits<double>::infinity();
  double greatest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double height = sides[1][i] * t[0].height + sides[2][i] * t[1].height + sides[0][i] * t[2].height;
    greatest = std::max(greatest, std::abs(height));
  }
  return greatest / area;
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
  const auto find_across = [&](std::uint32_t from, std::uint32_t to, std::uint32_t sheet) {
    const std::optional<std::uint32_t> t = edges.find_triangle(to, from, sheet);
    return t ? slots[*t] : kNoSlot;
  };
  for (std::uint32_t sheet = 0; sheet < sheets.count; ++sheet) {
    const mesh::TriangleTree* const tree = trees.find(sheet);
    if (tree == nullptr) continue;
    constexpr std::size_t kGrain = 1 << 10;
    for_each_index(
        tree->size(),
        [&](std::size_t slot) {
          const glm::uvec3& t = triangles[trees.triangle(sheet, static_cast<std::uint32_t>(slot))];
          neighbors_[first_[sheet] + slot] = {find_across(t.x, t.y, sheet), find_across(t.y, t.z, sheet),
                                              find_across(t.z, t.x, sheet)};
        },
        kGrain);
  }
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
  for (int step = 0;; ++step) {
    const FlatTriangle t = frame.flat(tree.corners(slot));
    if (step == kMostSteps || !frame.is_near(t)) return std::nullopt;
    double least = 0;
    double area = 0;
    std::size_t across = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto sides = sides_of_line(t[i], t[(i + 1) % 3]);
      const double side = (sides[0] + sides[1] + sides[2]) / 3;  // of the center
      area += side;
      if (side >= least) continue;
      least = side;
      across = i;
    }
    if (!(area > kRounding)) return std::nullopt;
    if (across == 3) {
      if (area < kLeastArea) return std::nullopt;
      break;
    }
    slot = neighbors(sheet, slot)[across];
    if (slot == kNoSlot) return std::nullopt;
  }
  mesh::TriangleBound bound;
  bound.slot = slot;
  std::array<std::uint32_t, kMostTriangles> found;
  found[0] = slot;
  std::size_t count = 1;
  for (std::size_t next = 0; next < count; ++next) {
    const FlatTriangle t = frame.flat(tree.corners(found[next]));
    if (!frame.is_near(t)) return std::nullopt;
    const std::array beyond{outside(t[0]), outside(t[1]), outside(t[2])};
    if ((beyond[0] & beyond[1] & beyond[2]) != 0) continue;
    std::array<std::array<double, 3>, 3> sides{sides_of_line(t[0], t[1]), sides_of_line(t[1], t[2]),
                                               sides_of_line(t[2], t[0])};
    const double area = sides[0][0] * t[2].at[0] + sides[0][1] * t[2].at[1] + sides[0][2] * t[2].at[2];
    const double orientation = area < 0 ? -1 : 1;
    std::array<bool, 3> is_met{};  // whether the line through an edge meets the triangle
    bool is_apart = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [least, most] =
          std::minmax({orientation * sides[i][0], orientation * sides[i][1], orientation * sides[i][2]});
      is_met[i] = least <= kRounding;
      is_apart |= most < -kRounding;
    }
    if (is_apart) continue;
    if (!(area > kRounding)) return std::nullopt;
    double height = std::min(greatest_height(t), greatest_height_of_plane(t, sides, area));
    if (height > enough) {
      const FlatPoint highest = highest_point(t, beyond[0] | beyond[1] | beyond[2]);
      height = std::abs(highest.height);
      if (height > enough) {
        bound.place = frame.foot(highest);
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
  return bound;
}

}  // namespace isoextract::edit

#include "mesh/detail/triangle_stars.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>

namespace isoextract::mesh {
namespace {

// More than the rounding of directions to float32.
constexpr double kDirectionRounding = 1e-6;

std::uint64_t key_of_side(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

FloatBox box_with_margin(const glm::dvec3& a, const glm::dvec3& b, double margin) {
  return {glm::vec3(glm::min(a, b) - margin), glm::vec3(glm::max(a, b) + margin)};
}

// Returns x divided by the length of (x, y, z): grows with x, approaches 0 as |y| or |z| grows.
double share(double x, double y, double z) { return x == 0 ? 0 : x / std::hypot(x, y, z); }

}  // namespace

void CrowdedStars::make(const std::vector<Sides>& crowded, const std::vector<std::uint32_t>& counts,
                        std::size_t triangles) {
  std::vector<std::uint64_t> sides;  // crowded ones, with repeats
  const auto each_side = [](const Sides& triangle, const auto& visit) {
    for (int corner = 0; corner < 3; ++corner) {
      visit(key_of_side(triangle.places[corner], triangle.places[(corner + 1) % 3]));
    }
  };
  for (const Sides& triangle : crowded) {
    each_side(triangle, [&](std::uint64_t key) {
      if (counts[key >> 32] > kFewTriangles && counts[key & kNone] > kFewTriangles) sides.push_back(key);
    });
  }
  std::ranges::sort(sides);
  std::unordered_map<std::uint64_t, std::uint32_t> number;  // of stars, by both ends of a side or twice a corner
  const auto star_at = [&](std::uint64_t key) {
    const auto [at, is_new] = number.try_emplace(key, static_cast<std::uint32_t>(stars_.size()));
    const auto low = static_cast<std::uint32_t>(key >> 32);
    const auto high = static_cast<std::uint32_t>(key & kNone);
    if (is_new) stars_.push_back({low, low == high ? kNone : high});
    return at->second;
  };
  of_ = Buffer<std::uint32_t>(triangles);
  std::fill(of_.begin(), of_.end(), kNone);
  for (const Sides& triangle : crowded) {
    int corner = 0;
    for (int other = 1; other < 3; ++other) {
      if (counts[triangle.places[other]] > counts[triangle.places[corner]]) corner = other;
    }
    std::uint64_t fullest = std::uint64_t{triangle.places[corner]} << 32 | triangle.places[corner];
    std::size_t most = kFewTriangles;
    each_side(triangle, [&](std::uint64_t key) {
      const auto [first, last] = std::equal_range(sides.begin(), sides.end(), key);
      const auto count = static_cast<std::size_t>(last - first);
      if (count <= most) return;
      most = count;
      fullest = key;
    });
    of_[triangle.triangle] = star_at(fullest);
  }
}

FloatBox CrowdedStars::directions(std::uint32_t star, const glm::uvec3& corners) const {
  const glm::dvec3 middle(positions_[stars_[star].middle]);
  std::array<glm::dvec3, 3> ways;
  std::size_t count = 0;
  for (int corner = 0; corner < 3; ++corner) {
    const glm::dvec3 way = glm::dvec3(positions_[corners[corner]]) - middle;
    if (way != glm::dvec3(0)) ways[count++] = way;
  }
  if (stars_[star].end == kNone) {
    const glm::dvec3 a = glm::normalize(ways[0]);
    const glm::dvec3 b = glm::normalize(ways[1]);
    // The arc between the directions leaves the box of its ends by at most its distance from the chord.
    const glm::dvec3 chord = a - b;
    const double bulge = 1 - std::sqrt(std::max(0.0, 1 - glm::dot(chord, chord) / 4));
    return box_with_margin(a, b, bulge + kDirectionRounding);
  }
  const glm::dvec3 side = glm::dvec3(positions_[stars_[star].end]) - middle;
  const glm::dvec3& tip = ways[0] == side ? ways[1] : ways[0];
  const glm::dvec3 across = glm::cross(side, tip);
  const double length = glm::length(across);
  const double error = 1e-14 * glm::length(side) * glm::length(tip) / length;
  if (!(error < 1)) return {glm::vec3(-2), glm::vec3(2)};
  return box_with_margin(across / length, across / length, kDirectionRounding + error);
}

FloatBox CrowdedStars::seen(std::uint32_t star, const FloatBox& box) const {
  const FloatBox all{glm::vec3(-2), glm::vec3(2)};
  if (stars_[star].end != kNone) return all;
  const glm::dvec3 middle(positions_[stars_[star].middle]);
  const glm::dvec3 low = glm::dvec3(box.min) - middle;
  const glm::dvec3 high = glm::dvec3(box.max) - middle;
  glm::dvec3 least(0);  // smallest absolute values in the box
  for (int axis = 0; axis < 3; ++axis) least[axis] = std::max({low[axis], -high[axis], 0.0});
  const glm::dvec3 most = glm::max(glm::abs(low), glm::abs(high));
  if (least == glm::dvec3(0)) return all;
  glm::dvec3 from(0);
  glm::dvec3 to(0);
  for (int axis = 0; axis < 3; ++axis) {
    const int y = (axis + 1) % 3;
    const int z = (axis + 2) % 3;
    from[axis] = low[axis] < 0 ? share(low[axis], least[y], least[z]) : share(low[axis], most[y], most[z]);
    to[axis] = high[axis] > 0 ? share(high[axis], least[y], least[z]) : share(high[axis], most[y], most[z]);
  }
  return {glm::vec3(from - kDirectionRounding), glm::vec3(to + kDirectionRounding)};
}

}  // namespace isoextract::mesh

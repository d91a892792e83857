#include "mesh/triangle_tree.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "mesh/distance_bound.hpp"

namespace isoextract::mesh {
namespace {

// Thin triangles around one vertex, in a plane that is not parallel to any axis.
struct Fan {
  std::vector<glm::vec3> positions{{0.1F, 0.2F, 0.3F}};
  std::vector<glm::uvec3> triangles;

  explicit Fan(unsigned n) {
    const glm::dvec3 right = glm::normalize(glm::dvec3(2, 1, -1));
    const glm::dvec3 up = glm::normalize(glm::cross(right, glm::dvec3(1, 1, 1)));
    for (unsigned i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      positions.emplace_back(glm::dvec3(positions[0]) + std::cos(angle) * right + std::sin(angle) * up);
      triangles.emplace_back(0, 1 + i, 1 + (i + 1) % n);
    }
  }
};

std::vector<glm::dvec3> points_near(const Fan& fan, std::size_t count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> part(0, 1);
  std::normal_distribution<double> off(0, 1e-3);
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    const glm::uvec3& t = fan.triangles[random() % fan.triangles.size()];
    const double far = std::sqrt(part(random));
    points.push_back(glm::mix(glm::dvec3(fan.positions[t.x]), glm::dvec3(fan.positions[t.y]), far) +
                     glm::dvec3(off(random), off(random), off(random)));
  }
  return points;
}

TEST(TriangleTreeTest, FindsNearestPointOfFan) {
  const Fan fan(3000);
  const TriangleTree tree(fan.positions, fan.triangles);
  EXPECT_TRUE(tree.has_slabs());
  for (const glm::dvec3& p : points_near(fan, 300)) {
    double expected = std::numeric_limits<double>::infinity();
    for (std::uint32_t slot = 0; slot < tree.size(); ++slot) {
      expected = std::min(expected, tree.nearest_on_triangle(slot, p).distance_squared);
    }
    EXPECT_EQ(tree.nearest(p, 17).distance_squared, expected);
  }
}

TEST(TriangleTreeTest, WorkDoesNotGrowWithFanSize) {
  std::array<double, 2> leaves{};
  for (const unsigned doubled : {0U, 1U}) {
    const Fan fan(8000U << doubled);
    const TriangleTree tree(fan.positions, fan.triangles);
    const std::vector<glm::dvec3> points = points_near(fan, 500);
    for (const glm::dvec3& p : points) {
      leaves[doubled] += static_cast<double>(tree.count_leaves_within(p, tree.nearest(p, 0).distance_squared)) / 500;
    }
  }
  EXPECT_LT(leaves[0], 8000.0 / 4 / 20);  // of all leaves
  EXPECT_LT(leaves[1], leaves[0] * 5 / 2);
}

struct Surface {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
};

Surface wavy_surface(unsigned side, float steps) {
  Surface surface;
  for (unsigned i = 0; i < side * side; ++i) {
    const auto x = static_cast<float>(i % side) * steps;
    const auto y = static_cast<float>(i / side) * steps;
    surface.positions.emplace_back(x, y, std::sin(x / 9) + 0.3F * y);
  }
  for (unsigned y = 0; y + 1 < side; ++y) {
    for (unsigned x = 0; x + 1 < side; ++x) {
      const unsigned v = y * side + x;
      surface.triangles.insert(surface.triangles.end(), {{v, v + 1, v + side + 1}, {v, v + side + 1, v + side}});
    }
  }
  return surface;
}

TEST(TriangleTreeTest, RegularSurfaceNeedsNoSlabs) {
  const Surface surface = wavy_surface(60, 1);
  EXPECT_FALSE(TriangleTree(surface.positions, surface.triangles).has_slabs());
}

TEST(TriangleTreeTest, FindsNearestPointFromAnyHint) {
  const Surface surface = wavy_surface(30, 1);
  const TriangleTree tree(surface.positions, surface.triangles);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> at(-10, 40);
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 p(at(random), at(random), i % 3 == 0 ? at(random) : std::sin(at(random) / 9));
    double expected = std::numeric_limits<double>::infinity();
    for (std::uint32_t slot = 0; slot < tree.size(); ++slot) {
      expected = std::min(expected, tree.nearest_on_triangle(slot, p).distance_squared);
    }
    EXPECT_EQ(tree.nearest(p, static_cast<std::uint32_t>(random() % tree.size())).distance_squared, expected);
  }
}

// A coarse surface above a fine one: each large triangle has many small ones below.
TEST(BoundDistance, DecidesAlikeForAnySlots) {
  const Surface fine = wavy_surface(60, 1);
  const Surface coarse = wavy_surface(12, 5);
  const TriangleTree tree(fine.positions, fine.triangles);
  DistanceLimits limits{.tolerance = 0, .floor = 1e-4};
  std::mt19937 random(7);
  int near = 0;
  for (const glm::uvec3& t : coarse.triangles) {
    const std::array<glm::dvec3, 3> corners{coarse.positions[t.x], coarse.positions[t.y], coarse.positions[t.z]};
    const TriangleBound exact = bound_distance(corners, tree, limits, 0, 0);
    std::array<std::uint32_t, 3> slots{};
    for (std::size_t i = 0; i < 3; ++i) slots[i] = tree.nearest(corners[i], 0).slot;
    for (const double enough : {0.5 * exact.upper, 0.9 * exact.upper, 1.1 * exact.upper}) {
      DistanceLimits until = limits;
      until.enough = until.refuse = enough;
      const TriangleBound found = bound_distance(corners, tree, until, 0, slots[0], slots);
      EXPECT_GE(found.upper, exact.lower);
      EXPECT_LE(found.lower, exact.upper);
      EXPECT_EQ(found.upper <= enough, exact.upper <= enough);
      near += found.upper <= enough ? 1 : 0;
    }
  }
  EXPECT_GT(near, 100);
}

}  // namespace
}  // namespace isoextract::mesh

#include "mesh/triangle_tree.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

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

TEST(TriangleTreeTest, RegularSurfaceNeedsNoSlabs) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  constexpr unsigned kSide = 60;
  for (unsigned i = 0; i < kSide * kSide; ++i) {
    const auto x = static_cast<float>(i % kSide);
    const auto y = static_cast<float>(i / kSide);
    positions.emplace_back(x, y, std::sin(x / 9) + 0.3F * y);
  }
  for (unsigned y = 0; y + 1 < kSide; ++y) {
    for (unsigned x = 0; x + 1 < kSide; ++x) {
      const unsigned v = y * kSide + x;
      triangles.insert(triangles.end(), {{v, v + 1, v + kSide + 1}, {v, v + kSide + 1, v + kSide}});
    }
  }
  EXPECT_FALSE(TriangleTree(positions, triangles).has_slabs());
}

}  // namespace
}  // namespace isoextract::mesh

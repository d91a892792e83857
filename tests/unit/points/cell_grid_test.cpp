// Tests finding points by cells, the nearest point, and lists of bricks against brute force.
#include <limits>
#include <set>
#include <tuple>

#include <gtest/gtest.h>

#include "points/cell_grid.hpp"
#include "points/detail/brick_list.hpp"
#include "points/detail/nearest_tree.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CellGrid grid_of(const std::vector<glm::dvec3>& points, double side, CellGrid::Coinciding coinciding) {
  auto grid = CellGrid::make(points, {glm::dvec3(0.5), 2}, side, coinciding, Context(), "test");
  EXPECT_TRUE(grid);
  return std::move(*grid);
}

TEST(CellGrid, FindsEveryPointOnce) {
  std::vector<glm::dvec3> points = random_positions(500, 20, 1);
  for (glm::dvec3& p : points) p -= 10.0;  // cells on both sides of 0
  points.emplace_back(2e6, -3e5, 1e6);     // strays
  points.emplace_back(kNan, 0, 0);         // not a position
  points.emplace_back(0, std::numeric_limits<double>::infinity(), 0);
  const CellGrid grid = grid_of(points, 1.3, CellGrid::Coinciding::merged);
  EXPECT_EQ(grid.size(), 501U);
  const GridFrame frame{glm::dvec3(0.5), 2};
  const std::vector<glm::dvec3> corners = random_positions(40, 12, 2);
  for (std::size_t n = 0; n < corners.size(); n += 2) {
    const glm::dvec3 low = glm::min(corners[n], corners[n + 1]) - 6.0;
    const glm::dvec3 high = glm::max(corners[n], corners[n + 1]) - 6.0;
    std::multiset<std::uint32_t> found;
    grid.for_each_spot_run(low, high, [&](std::size_t first, std::size_t last) {
      for (std::size_t s = first; s < last; ++s) {
        for (const std::uint32_t point : grid.members(s)) found.insert(point);
        EXPECT_EQ(grid.position(s), frame(points[grid.members(s)[0]]));
      }
    });
    for (std::uint32_t i = 0; i < 501; ++i) {
      const glm::dvec3 p = frame(points[i]);
      const bool within = glm::all(glm::greaterThanEqual(p, low)) && glm::all(glm::lessThanEqual(p, high));
      EXPECT_LE(found.count(i), 1U);
      EXPECT_TRUE(!within || found.contains(i)) << i;
    }
  }
}

TEST(CellGrid, MergesCoincidentPointsOfACrowdedCell) {
  std::vector<glm::dvec3> points;
  for (int n = 0; n < 300; ++n) points.emplace_back(0.25 * (n % 3), 0.5, 0.5);
  const CellGrid merged = grid_of(points, 100, CellGrid::Coinciding::merged);
  ASSERT_EQ(merged.size(), 3U);
  for (std::size_t s = 0; s < 3; ++s) EXPECT_EQ(merged.members(s).size(), 100U);
  EXPECT_EQ(grid_of(points, 100, CellGrid::Coinciding::apart).size(), 300U);
  EXPECT_EQ(grid_of({}, 1, CellGrid::Coinciding::merged).size(), 0U);
}

TEST(NearestTree, FindsTheNearest) {
  std::vector<glm::dvec3> points = random_positions(700, 1, 3);
  for (int n = 0; n < 300; ++n) points.emplace_back(0.5, 0.5, 0.5);
  points.emplace_back(kNan, 0, 0);
  points.emplace_back(1e9, 0, 0);
  const auto tree = NearestTree::make(points, Context(), "test");
  ASSERT_TRUE(tree);
  std::vector<glm::dvec3> asked = random_positions(100, 1.2, 4);
  asked.insert(asked.end(), {points[0], points[700], points.back()});
  for (const glm::dvec3& p : asked) {
    NearestTree::Found expected;
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      const double squared = glm::dot(points[i] - p, points[i] - p);
      if (squared < expected.squared_distance) expected = {squared, i};
    }
    const NearestTree::Found found = tree->nearest(p);
    EXPECT_EQ(found.squared_distance, expected.squared_distance);
    EXPECT_EQ(found.point, expected.point);
    EXPECT_LE(tree->squared_distance_to_bounds(p), expected.squared_distance);
  }
  EXPECT_DOUBLE_EQ(tree->squared_distance_to_bounds({0.5, 0.5, -7}), 49);
}

using Triple = std::tuple<int, int, int>;

std::set<Triple> set_of(std::span<const glm::ivec3> bricks) {
  std::set<Triple> set;
  for (const glm::ivec3& b : bricks) set.emplace(b.x, b.y, b.z);
  return set;
}

TEST(BrickList, DilatesAndErodesByRings) {
  std::set<Triple> chosen;
  for (const glm::dvec3& p : random_positions(3000, 9, 7)) {
    chosen.emplace(static_cast<int>(p.x) - 4, static_cast<int>(p.y) - 4, static_cast<int>(p.z) - 4);
  }
  chosen.emplace(100000, -5, 70000);
  std::vector<glm::ivec3> bricks;
  for (const auto& [x, y, z] : chosen) bricks.emplace_back(x, y, z);
  for (const int rings : {0, 1, 2, 3}) {
    std::set<Triple> grown;
    std::set<Triple> shrunk;
    for (const glm::ivec3& b : bricks) {
      bool whole = true;
      for (int x = -rings; x <= rings; ++x) {
        for (int y = -rings; y <= rings; ++y) {
          for (int z = -rings; z <= rings; ++z) {
            grown.emplace(b.x + x, b.y + y, b.z + z);
            whole = whole && chosen.contains({b.x + x, b.y + y, b.z + z});
          }
        }
      }
      if (whole) shrunk.emplace(b.x, b.y, b.z);
    }
    const auto more = dilated(bricks, rings, Context(), "test");
    ASSERT_TRUE(more);
    EXPECT_EQ(set_of((*more)->values.span()), grown);
    EXPECT_TRUE(std::ranges::is_sorted((*more)->values, brick_before));
    EXPECT_EQ((*more)->values.size(), grown.size()) << "none twice";
    if (rings != 1) continue;
    ASSERT_FALSE(shrunk.empty());
    const auto less = eroded(bricks, Context(), "test");
    ASSERT_TRUE(less);
    EXPECT_EQ(set_of((*less)->values.span()), shrunk);
    EXPECT_EQ((*less)->values.size(), shrunk.size());
  }
}

}  // namespace
}  // namespace isoextract::points

#include "mesh/greatest_distance.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace isoextract::mesh {
namespace {

// Distances to a square in the plane z = 0.
class GreatestDistanceTest : public ::testing::Test {
 protected:
  std::vector<glm::vec3> square_{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}};
  std::vector<glm::uvec3> halves_{{0, 1, 2}, {0, 2, 3}};
  TriangleTree tree_{square_, halves_};
  Context context_;

  [[nodiscard]] GreatestDistance search(const PlacedTriangles& from, double tolerance = 1e-6) const {
    GreatestDistanceSearch found(from, tree_, {.tolerance = tolerance, .floor = 1e-12}, context_);
    found.measure_corners();
    return found.bound_triangles();
  }
};

TEST_F(GreatestDistanceTest, IsReachedAtCorner) {
  const std::vector<glm::vec3> positions{{1, 1, 1}, {2, 1, 1}, {2, 2, 3}};
  const std::vector<glm::uvec3> triangle{{0, 1, 2}};
  const auto found = search({positions, triangle, {}});
  EXPECT_DOUBLE_EQ(found.lower, 3);
  EXPECT_GE(found.upper, 3);
  EXPECT_LE(found.upper, 3 * (1 + 1e-6));
  EXPECT_EQ(found.place, glm::dvec3(2, 2, 3));
  EXPECT_EQ(found.nearest, glm::dvec3(2, 2, 0));
}

// The corners are at the two sides of a gap; the farthest point is in the middle of it.
TEST_F(GreatestDistanceTest, IsReachedInsideTriangle) {
  const std::vector<glm::vec3> posts{{-3, 0, 0}, {-3, 4, 0}, {-4, 2, 0}, {3, 0, 0}, {3, 4, 0}, {4, 2, 0}};
  const std::vector<glm::uvec3> two{{0, 1, 2}, {3, 5, 4}};
  const TriangleTree tree(posts, two);
  const std::vector<glm::uvec3> across{{0, 3, 1}, {3, 4, 1}};
  GreatestDistanceSearch search({posts, across, {}}, tree, {.tolerance = 1e-3, .floor = 1e-12}, context_);
  search.measure_corners();
  EXPECT_EQ(search.lower(), 0);
  const auto found = search.bound_triangles();
  EXPECT_GE(found.lower, 3 / (1 + 1e-3));
  EXPECT_LE(found.lower, 3);
  EXPECT_GE(found.upper, 3);
  EXPECT_LE(found.upper, 3 * (1 + 2e-3));
}

TEST_F(GreatestDistanceTest, AppliesShiftAndSkipsExcludedTriangles) {
  const std::vector<glm::vec3> positions{{1, 1, 1}, {2, 1, 1}, {2, 2, 3}, {1, 1, 50}};
  const std::vector<glm::uvec3> triangles{{0, 1, 2}, {0, 1, 3}};
  const std::vector<char> second{0, 1};
  const auto found = search({positions, triangles, second, {0, 0, 4}});
  EXPECT_DOUBLE_EQ(found.lower, 7);
  EXPECT_LT(found.upper, 7.1);
  const std::vector<char> both{1, 1};
  const auto none = search({positions, triangles, both});
  EXPECT_EQ(none.lower, 0);
  EXPECT_EQ(none.upper, 0);
}

}  // namespace
}  // namespace isoextract::mesh

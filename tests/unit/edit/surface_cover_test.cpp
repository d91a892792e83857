#include "edit/detail/surface_cover.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "edit/detail/edge_search.hpp"
#include "edit/detail/sheet_trees.hpp"
#include "mesh/distance_bound.hpp"

namespace isoextract::edit {
namespace {

constexpr unsigned kSide = 13;  // vertices along a side
using Points = std::array<glm::dvec3, 3>;

// A square of triangles with heights, one unit wide each; without those `left_out`.
struct Terrain {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<char> left_out;

  explicit Terrain(float roughness) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> height(-roughness, roughness);
    for (unsigned v = 0; v < kSide * kSide; ++v) {
      positions.emplace_back(static_cast<float>(v % kSide), static_cast<float>(v / kSide), height(random));
      if (v % kSide + 1 == kSide || v / kSide + 1 == kSide) continue;
      triangles.insert(triangles.end(), {{v, v + 1, v + kSide + 1}, {v, v + kSide + 1, v + kSide}});
    }
    left_out.assign(triangles.size(), 0);
  }

  [[nodiscard]] const mesh::TriangleTree& tree() const { return trees().tree(0); }
  [[nodiscard]] std::optional<mesh::TriangleBound> bound(const Points& triangle, double enough) const {
    const std::vector<std::uint32_t> slots = trees().slots(triangles.size());
    const SurfaceCover cover(trees(), slots, triangles, positions.size(), left_out, {});
    const std::uint32_t near = tree().nearest((triangle[0] + triangle[1] + triangle[2]) / 3.0, 0).slot;
    return cover.bound(triangle, tree(), 0, near, enough);
  }

 private:
  [[nodiscard]] const SheetTrees& trees() const {
    if (!trees_) trees_.emplace(positions, triangles, left_out, Sheets());
    return *trees_;
  }
  mutable std::optional<SheetTrees> trees_;
};

TEST(SurfaceCover, AgreesWithSearches) {
  const Terrain terrain(0.3F);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(1, kSide - 2);
  std::uniform_real_distribution<double> height(-0.1, 0.1);
  std::size_t proven = 0;
  std::size_t refused = 0;
  for (int i = 0; i < 2000; ++i) {
    Points triangle;
    for (glm::dvec3& p : triangle) p = {place(random), place(random), height(random)};
    if (glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]).z < 0) std::swap(triangle[0], triangle[1]);
    constexpr double kEnough = 0.25;
    const auto found = terrain.bound(triangle, kEnough);
    if (!found) continue;
    const mesh::TriangleBound exact = mesh::bound_distance(triangle, terrain.tree(), {.tolerance = 1e-3}, 0, 0);
    if (found->upper <= kEnough) {
      ++proven;
      EXPECT_LE(exact.lower, found->upper + 1e-12) << i;
    } else {
      ++refused;
      EXPECT_GT(found->lower, kEnough);
      EXPECT_NEAR(glm::length(found->place - found->nearest), found->lower, 1e-12);
      EXPECT_NEAR(std::sqrt(terrain.tree().nearest(found->place, 0).distance_squared), found->lower, 1e-9);
      EXPECT_GE(exact.upper, found->lower - 1e-12) << i;
    }
  }
  EXPECT_GT(proven, 20U);
  EXPECT_GT(refused, 100U);
}

TEST(SurfaceCover, ProvesFlatSurface) {
  const Terrain flat(0);
  const auto found = flat.bound({{{2.2, 2.1, 0.125}, {9.7, 3.4, 0.125}, {5.1, 8.8, 0.125}}}, 0.2);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->upper, 0.125, 1e-12);
}

TEST(SurfaceCover, ProvesNothingOverHoles) {
  Terrain holed(0);
  holed.left_out[2 * ((kSide - 1) * 4 + 5)] = 1;  // from (5, 4) to (6, 5)
  EXPECT_FALSE(holed.bound({{{2.2, 2.1, 0}, {9.7, 3.4, 0}, {5.1, 8.8, 0}}}, 2));
  EXPECT_TRUE(holed.bound({{{1.2, 1.1, 0}, {3.7, 1.4, 0}, {2.1, 3.8, 0}}}, 2));
}

TEST(SurfaceCover, ProvesNothingBeyondTheBoundary) {
  const Terrain flat(0);
  EXPECT_FALSE(flat.bound({{{2.2, 2.1, 0}, {12.5, 3.4, 0}, {5.1, 8.8, 0}}}, 2));
}

TEST(SurfaceCover, ProvesNothingForOtherSide) {
  const Terrain flat(0);
  EXPECT_FALSE(flat.bound({{{9.7, 3.4, 0}, {2.2, 2.1, 0}, {5.1, 8.8, 0}}}, 2));
}

TEST(SurfaceCover, ProvesNothingUnderFolds) {
  Terrain folded(0);
  folded.positions[6 * kSide + 6].x = 8.5F;  // over the triangles beyond its neighbors
  EXPECT_FALSE(folded.bound({{{2.2, 2.1, 0}, {10.7, 3.4, 0}, {5.1, 10.8, 0}}}, 2));
}

TEST(EdgeSearch, FindsTheFirstTriangleOfASheetAlongAnEdge) {
  // Four triangles run from vertex 0 to vertex 1; sheet 1 has the last two.
  const std::vector<glm::uvec3> triangles{{0, 1, 2}, {1, 0, 3}, {4, 0, 1}, {1, 5, 0}, {0, 1, 6}};
  const std::vector<std::uint32_t> of_triangle{0, 0, 0, 1, 1};
  std::vector<char> left_out(triangles.size(), 0);
  const Sheets sheets{of_triangle, 2};
  EXPECT_EQ(EdgeSearch(triangles, 7, left_out, sheets).find_triangle(0, 1, 0), 0U);
  EXPECT_EQ(EdgeSearch(triangles, 7, left_out, sheets).find_triangle(1, 0, 0), 1U);
  EXPECT_EQ(EdgeSearch(triangles, 7, left_out, sheets).find_triangle(0, 1, 1), 3U);
  EXPECT_EQ(EdgeSearch(triangles, 7, left_out, sheets).find_triangle(1, 0, 1), std::nullopt);
  left_out[0] = 1;
  EXPECT_EQ(EdgeSearch(triangles, 7, left_out, sheets).find_triangle(0, 1, 0), 2U);
}

TEST(EdgeSearch, VisitsFewCornersAroundTheApexOfACone) {
  constexpr unsigned kTriangles = 100'000;
  std::vector<glm::uvec3> triangles;
  for (unsigned i = 0; i < kTriangles; ++i) triangles.emplace_back(kTriangles, i, (i + 1) % kTriangles);
  const std::vector<char> left_out(kTriangles, 0);
  const Sheets sheets;
  const EdgeSearch edges(triangles, kTriangles + 1, left_out, sheets);
  std::uint64_t visited = 0;
  for (unsigned i = 0; i < kTriangles; ++i) {
    ASSERT_EQ(edges.find_triangle(kTriangles, i, 0, &visited), i);
    ASSERT_EQ(edges.find_triangle(i, kTriangles, 0, &visited), (i + kTriangles - 1) % kTriangles);
    ASSERT_LE(visited, 8U * (i + 1U));
  }
}

}  // namespace
}  // namespace isoextract::edit

#include "edit/detail/surface_cover.hpp"

#include <algorithm>
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
  std::vector<std::uint32_t> of_triangle;  // sheets; empty: one

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

  // Adds triangles before the others, from the middle line to a parallel one that lies `across` and a little above.
  void add_flap(float across, std::uint32_t sheet) {
    std::vector<glm::uvec3> flap;
    const auto first = static_cast<unsigned>(positions.size());
    for (unsigned j = 0; j < kSide; ++j) {
      const unsigned v = kSide * j + kSide / 2;
      positions.push_back(positions[v] + glm::vec3(across, 0, 0.1F));
      if (j + 1 == kSide) continue;
      flap.insert(flap.end(), {{v, first + j, first + j + 1}, {v, first + j + 1, v + kSide}});
    }
    of_triangle.assign(flap.size(), sheet);
    of_triangle.resize(flap.size() + triangles.size(), 0);
    triangles.insert(triangles.begin(), flap.begin(), flap.end());
    left_out.assign(triangles.size(), 0);
  }

  [[nodiscard]] const mesh::TriangleTree& tree() const { return trees().tree(0); }
  [[nodiscard]] std::optional<mesh::TriangleBound> bound(const Points& triangle, double enough) const {
    const std::vector<std::uint32_t> slots = trees().slots(triangles.size());
    const SurfaceCover cover(trees(), slots, triangles, positions.size(), left_out, sheets());
    const std::uint32_t near = tree().nearest((triangle[0] + triangle[1] + triangle[2]) / 3.0, 0).slot;
    return cover.bound(triangle, tree(), 0, near, enough);
  }

 private:
  [[nodiscard]] Sheets sheets() const { return {of_triangle, of_triangle.empty() ? 1U : 2U}; }
  [[nodiscard]] const SheetTrees& trees() const {
    if (!trees_) trees_.emplace(positions, triangles, left_out, sheets());
    return *trees_;
  }
  mutable std::optional<SheetTrees> trees_;
};

// Bounds random triangles with corners up to `wide` apart along x, and expects the intervals of exact searches.
struct Agreement {
  std::size_t proven = 0;
  std::size_t refused = 0;

  Agreement(const Terrain& terrain, double wide, double enough) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(1, kSide - 2);
    std::uniform_real_distribution<double> height(-0.1, 0.1);
    std::uniform_real_distribution<double> aside(0, wide);
    for (int i = 0; i < 1500; ++i) {
      Points triangle;
      const double x = std::min(place(random), kSide - 2 - wide);
      for (glm::dvec3& p : triangle) p = {x + aside(random), place(random), height(random)};
      if (glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]).z < 0) std::swap(triangle[0], triangle[1]);
      const auto found = terrain.bound(triangle, enough);
      if (!found) continue;
      const mesh::TriangleBound exact = mesh::bound_distance(triangle, terrain.tree(), {.tolerance = 1e-3}, 0, 0);
      if (found->upper <= enough) {
        ++proven;
        EXPECT_LE(exact.lower, found->upper + 1e-12) << i;
      } else {
        ++refused;
        EXPECT_GT(found->lower, enough);
        EXPECT_NEAR(glm::length(found->place - found->nearest), found->lower, 1e-12);
        EXPECT_NEAR(std::sqrt(terrain.tree().nearest(found->place, 0).distance_squared), found->lower, 1e-9);
        EXPECT_GE(exact.upper, found->lower - 1e-12) << i;
      }
    }
  }
};

TEST(SurfaceCover, AgreesWithSearches) {
  const Agreement found(Terrain(0.3F), kSide - 3, 0.25);
  EXPECT_GT(found.proven, 20U);
  EXPECT_GT(found.refused, 100U);
}

TEST(SurfaceCover, AgreesWithSearchesForThinTriangles) {
  for (const double wide : {0.5, 0.05, 0.01}) {
    const Agreement found(Terrain(0.2F), wide, 0.2);
    EXPECT_GT(found.proven, 5U) << wide;
    EXPECT_GT(found.refused, 20U) << wide;
  }
}

// Every second column of the terrain is very narrow, so that its triangles are needles and steep.
TEST(SurfaceCover, AgreesWithSearchesOverNeedles) {
  for (const float narrow : {0.1F, 0.01F, 0.001F}) {
    Terrain terrain(0.02F);
    for (glm::vec3& p : terrain.positions) {
      const auto column = static_cast<int>(p.x);
      if (column % 2 == 1) p.x = static_cast<float>(column - 1) + narrow;
    }
    const Agreement found(terrain, kSide - 3, 0.1);
    EXPECT_GT(found.proven, 20U) << narrow;
    EXPECT_GT(found.refused, 20U) << narrow;
  }
}

TEST(SurfaceCover, AgreesWithSearchesAtNonManifoldEdges) {
  for (const float across : {-0.5F, 0.5F, 4.0F}) {
    Terrain terrain(0.2F);
    terrain.add_flap(across, 0);
    const Agreement found(terrain, 3, 0.2);
    EXPECT_GT(found.proven, 20U) << across;
    EXPECT_GT(found.refused, 20U) << across;
  }
}

// The flap is of another sheet, so the walk crosses the line where both meet, and finds the dent behind it.
TEST(SurfaceCover, WalksWithinItsSheet) {
  for (const float across : {-0.5F, 0.5F}) {
    Terrain dented(0);
    dented.positions[4 * kSide + 8].z = -0.05F;
    dented.add_flap(across, 1);
    const auto found = dented.bound({{{2.2, 2.1, 0.125}, {9.7, 3.4, 0.125}, {5.1, 8.8, 0.125}}}, 0.2);
    ASSERT_TRUE(found) << across;
    EXPECT_NEAR(found->upper, 0.175, 1e-7);
  }
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

TEST(SurfaceCover, ProvesEitherSide) {
  const Terrain flat(0);
  const auto found = flat.bound({{{9.7, 3.4, 0.125}, {2.2, 2.1, 0.125}, {5.1, 8.8, 0.125}}}, 0.2);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->upper, 0.125, 1e-12);
}

TEST(SurfaceCover, ProvesUnderFolds) {
  Terrain folded(0);
  folded.positions[6 * kSide + 6].x = 8.5F;  // over the triangles beyond its neighbors
  const auto found = folded.bound({{{2.2, 2.1, 0.125}, {10.7, 3.4, 0.125}, {5.1, 10.8, 0.125}}}, 0.2);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->upper, 0.125, 1e-12);
}

TEST(SurfaceCover, AgreesWithSearchesUnderFolds) {
  Terrain folded(0.2F);
  for (unsigned v = 0; v < folded.positions.size(); v += 5) folded.positions[v].x += 1.4F;
  const Agreement found(folded, 3, 0.2);
  EXPECT_GT(found.proven, 20U);
  EXPECT_GT(found.refused, 20U);
}

// The surface ends at a fold: two layers on one side of it, none on the other.
TEST(SurfaceCover, ProvesNothingBeyondAFold) {
  Terrain folded(0);
  for (glm::vec3& p : folded.positions) p.x = std::min(p.x, 12 - p.x);
  const Points beyond{{{3.2, 2.1, 0}, {9.7, 3.4, 0}, {4.1, 8.8, 0}}};
  EXPECT_FALSE(folded.bound(beyond, 8));
  EXPECT_NEAR(mesh::bound_distance(beyond, folded.tree(), {.tolerance = 1e-3}, 0, 0).lower, 3.7, 0.01);
}

// Triangles that touch the given one at its corners and sides only are not part of the cover.
TEST(SurfaceCover, IgnoresTrianglesThatOnlyTouch) {
  Terrain steep(0);
  for (unsigned v = 0; v < steep.positions.size(); ++v) {
    const glm::vec3& p = steep.positions[v];
    const bool is_corner = p == glm::vec3(4, 4, 0) || p == glm::vec3(5, 4, 0) || p == glm::vec3(5, 5, 0);
    if (!is_corner) steep.positions[v].z = 9;
  }
  const auto found = steep.bound({{{4, 4, 0}, {5, 4, 0}, {5, 5, 0}}}, 0.2);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->upper, 0);
}

// Heights above the plane are up to 1.25 times the distances here.
TEST(SurfaceCover, MeasuresAcrossSlopes) {
  Terrain slope(0);
  for (glm::vec3& p : slope.positions) p.z = 0.75F * p.x;
  const Points level{{{5.9, 5.4, 4.5}, {6.1, 5.4, 4.5}, {6, 5.6, 4.5}}};
  const auto found = slope.bound(level, 0.07);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->upper, 0.06, 1e-9);
  EXPECT_GT(slope.bound(level, 0.05)->lower, 0.05);
}

// A terrain of two floors with the y axis between them, the second one `step` higher; upright triangles join them.
Terrain stairs(float step) {
  Terrain terrain(0);
  constexpr unsigned kMiddle = kSide / 2;
  for (unsigned v = 0; v < terrain.positions.size(); ++v) {
    const unsigned column = v % kSide;
    const bool is_upper = column > kMiddle;
    terrain.positions[v] = {static_cast<float>(column) - static_cast<float>(is_upper ? kMiddle + 1 : kMiddle),
                            terrain.positions[v].y - kMiddle, is_upper ? step : 0};
  }
  return terrain;
}

TEST(SurfaceCover, ProvesNoMoreThanUprightTrianglesAllow) {
  const Terrain terrain = stairs(1);
  for (const double tilt : {0.0, 1e-15, -1e-15, 1e-12}) {
    const Points across{{{-3, -1, 0}, {2, 0.25, tilt}, {-3, 1, 0}}};
    const auto found = terrain.bound(across, 0.2);
    EXPECT_FALSE(found && found->upper <= 0.2) << tilt;
    const auto far = terrain.bound(across, 1.5);
    ASSERT_TRUE(far) << tilt;
    EXPECT_NEAR(far->upper, 1, 1e-6);
  }
}

// A step of 0 leaves triangles without area, and edges without length.
TEST(SurfaceCover, ProvesAcrossTrianglesWithoutArea) {
  const auto found = stairs(0).bound({{{-3, -1, 0.125}, {2, 0.25, 0.125}, {-3, 1, 0.125}}}, 0.2);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->upper, 0.125, 1e-12);
}

// Two triangles run along the common edge in each direction, so none of them has a neighbor there.
TEST(SurfaceCover, ProvesNothingAcrossNonManifoldEdges) {
  Terrain book(0);
  book.positions = {{0, -20, 0}, {0, 20, 0}, {-40, 0, 0}, {0.01F, 0, 0}, {40, 0, -400}};
  book.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 3}, {1, 0, 4}};
  book.left_out.assign(4, 0);
  const auto found = book.bound({{{-3, -1, 0}, {2, 0, 0}, {-3, 1, 0}}}, 0.2);
  EXPECT_FALSE(found && found->upper <= 0.2);
}

// Returns the triangles across the edges that start at the corners of each triangle.
std::vector<std::array<std::optional<std::uint32_t>, 3>> all_across(const std::vector<glm::uvec3>& triangles,
                                                                    std::size_t vertices, const Sheets& sheets,
                                                                    const std::vector<char>& left_out) {
  const EdgeSearch edges(triangles, vertices, left_out, sheets);
  std::vector<std::array<std::optional<std::uint32_t>, 3>> across(triangles.size());
  std::size_t corners = 0;
  for (std::uint32_t v = 0; v < vertices; ++v) {
    edges.for_each_across(v, [&](std::uint32_t t, std::uint32_t corner, std::optional<std::uint32_t> other) {
      EXPECT_EQ(triangles[t][static_cast<int>(corner)], v);
      across[t][corner] = other;
      ++corners;
    });
  }
  EXPECT_EQ(corners, 3 * static_cast<std::size_t>(std::ranges::count(left_out, 0)));
  return across;
}

TEST(EdgeSearch, FindsTheOnlyTriangleOfASheetAcrossAnEdge) {
  // Triangles 0 to 2 are around edge 0 1 in sheet 0, and 3 and 4 in sheet 1. Triangle 5 has a corner twice.
  const std::vector<glm::uvec3> triangles{{0, 1, 2}, {1, 0, 3}, {4, 0, 1}, {1, 5, 0}, {0, 1, 6}, {7, 7, 8}};
  const std::vector<std::uint32_t> of_triangle{0, 0, 0, 1, 1, 0};
  std::vector<char> left_out(triangles.size(), 0);
  const Sheets sheets{of_triangle, 2};
  auto across = all_across(triangles, 9, sheets, left_out);
  EXPECT_EQ(across[0][0], std::nullopt) << "two triangles run from 0 to 1";
  EXPECT_EQ(across[1][0], std::nullopt);
  EXPECT_EQ(across[2][1], std::nullopt);
  EXPECT_EQ(across[3][2], std::nullopt) << "both run from 0 to 1";
  for (const auto& other : across[5]) EXPECT_EQ(other, std::nullopt);
  left_out[2] = 1;
  across = all_across(triangles, 9, sheets, left_out);
  EXPECT_EQ(across[0][0], 1U);
  EXPECT_EQ(across[1][0], 0U);
}

// A vertex with a few triangles, and one with many: a fan of which one triangle is of another sheet.
TEST(EdgeSearch, FindsTrianglesAroundAVertex) {
  for (const unsigned around : {5U, 15U, 16U, 17U, 40U}) {
    std::vector<glm::uvec3> triangles;
    for (unsigned i = 0; i < around; ++i) triangles.emplace_back(i, (i + 1) % around, around);
    triangles.emplace_back(around, around - 1, around + 1);  // along an edge of the fan
    std::vector<std::uint32_t> of_triangle(triangles.size(), 0);
    of_triangle[2] = 1;
    const std::vector<char> left_out(triangles.size(), 0);
    const auto across = all_across(triangles, around + 2, Sheets{of_triangle, 2}, left_out);
    for (unsigned i = 0; i < around; ++i) {
      const bool next_is_known = i != 1 && i != 2 && i + 2 != around;
      EXPECT_EQ(across[i][1], next_is_known ? std::optional((i + 1) % around) : std::nullopt) << around << " " << i;
      EXPECT_EQ(across[i][0], std::nullopt);
    }
  }
}

TEST(EdgeSearch, IsFastAroundTheApexOfACone) {
  constexpr unsigned kTriangles = 100'000;
  std::vector<glm::uvec3> triangles;
  for (unsigned i = 0; i < kTriangles; ++i) triangles.emplace_back(kTriangles, i, (i + 1) % kTriangles);
  const std::vector<char> left_out(kTriangles, 0);
  const auto across = all_across(triangles, kTriangles + 1, Sheets(), left_out);
  for (unsigned i = 0; i < kTriangles; ++i) ASSERT_EQ(across[i][0], (i + kTriangles - 1) % kTriangles);
}

}  // namespace
}  // namespace isoextract::edit

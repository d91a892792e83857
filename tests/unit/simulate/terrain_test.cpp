// Noise, and the land made from it.
#include "simulate/terrain.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "simulate/detail/perlin_noise.hpp"

namespace isoextract::simulate {
namespace {

TEST(PerlinNoise, IsZeroAndSmoothOnLattice) {
  const PerlinNoise noise(7);
  double most = 0;
  for (int n = 0; n < 300; ++n) {
    const glm::dvec3 corner(n % 7 - 3, n % 11 - 200, n % 300);
    EXPECT_EQ(noise(corner), 0.0);
    const glm::dvec3 inside = corner + glm::dvec3(0.31, 0.77, 0.5 + 0.001 * n);
    most = std::max(most, std::abs(noise(inside)));
    // Value and slope are continuous across the faces of lattice cubes.
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 on = inside;
      on[axis] = corner[axis];
      const auto at = [&](double d) {
        glm::dvec3 moved = on;
        moved[axis] += d;
        return noise(moved);
      };
      EXPECT_NEAR(at(1e-6) - at(0), at(0) - at(-1e-6), 1e-11);
    }
  }
  EXPECT_GT(most, 0.3);
  EXPECT_LT(most, 1.04);
}

TEST(FractalNoise, IsNonZeroAtOriginAndDependsOnSeed) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    EXPECT_GT(std::abs(FractalNoise(seed, 1)(glm::dvec3(0.0))), 1e-6);
    EXPECT_NE(FractalNoise(seed, 4)(glm::dvec3(0.5)), FractalNoise(seed + 1, 4)(glm::dvec3(0.5)));
  }
}

TEST(Terrain, DependsOnSeed) {
  TerrainOptions options;
  options.size = {40, 30};
  options.relief = 12;
  const auto land = make_terrain(options, Context());
  const auto again = make_terrain(options, Context());
  options.seed = 2;
  const auto other = make_terrain(options, Context());
  ASSERT_TRUE(land && again && other);
  const auto heights = (*land)->values.span();
  ASSERT_EQ(heights.size(), 1200U);
  EXPECT_TRUE(std::ranges::equal(heights, (*again)->values.span()));
  EXPECT_FALSE(std::ranges::equal(heights, (*other)->values.span()));
  EXPECT_DOUBLE_EQ(std::ranges::min(heights), kMinLandHeight);
  EXPECT_DOUBLE_EQ(std::ranges::max(heights), kMinLandHeight + 12);
}

TEST(Terrain, SlopesIntoBasin) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    TerrainOptions options;
    options.seed = seed;
    const auto land = make_terrain(options, Context());
    ASSERT_TRUE(land);
    double near = 0;
    double far = 0;
    int near_cells = 0;
    int far_cells = 0;
    for (int y = 0; y < options.size.y; ++y) {
      for (int x = 0; x < options.size.x; ++x) {
        const glm::dvec2 away = glm::dvec2(x, y) / glm::dvec2(options.size) - kBasin;
        const double height = (*land)->values[static_cast<std::size_t>(x + options.size.x * y)];
        if (glm::length(away) < 0.15) near += height, ++near_cells;
        if (glm::length(away) > 0.45) far += height, ++far_cells;
      }
    }
    EXPECT_LT(near / near_cells, 0.6 * far / far_cells) << "seed " << seed;
  }
}

TEST(Terrain, IsFlatForZeroRelief) {
  TerrainOptions options;
  options.relief = 0;
  const auto land = make_terrain(options, Context());
  ASSERT_TRUE(land);
  EXPECT_TRUE(std::ranges::all_of((*land)->values.span(), [](double height) { return height == kMinLandHeight; }));
}

TEST(Terrain, RejectsInvalidOptions) {
  TerrainOptions options;
  options.size = {1, 5};
  EXPECT_EQ(make_terrain(options, Context()).error().code, ErrorCode::usage);
  options = {};
  options.relief = std::nan("");
  EXPECT_EQ(make_terrain(options, Context()).error().code, ErrorCode::usage);
  options = {};
  options.octaves = 17;
  EXPECT_EQ(make_terrain(options, Context()).error().code, ErrorCode::usage);
  EXPECT_EQ(make_terrain({}, Context(MemoryBudget(1000))).error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::simulate

#include "field/surface_estimate.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <sys/resource.h>

#include "field/sparse_lookup.hpp"

namespace isoextract::field {
namespace {

ScalarField dense_field(std::vector<float> values, glm::ivec3 dims) {
  auto owner = std::make_shared<std::vector<float>>(std::move(values));
  ScalarField field;
  field.samples = DenseSamples{SampleType::f32, dims, owner, owner->data()};
  return field;
}

TEST(EstimateVertices, CountsCrossingsWithinRowsOnly) {
  // Two rows of four: the ends of adjacent rows do not count as a crossing.
  const ScalarField field = dense_field({0, 0, 1, 1, 0, 1, 1, 0}, {4, 2, 1});
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 3U * 3U);
  EXPECT_EQ(estimate_surface(field, 1).vertices, 0U);  // a value equal to iso is outside
}

TEST(EstimateVertices, CountsWithinABox) {
  // Slices of 4x3 samples; inside are the first sample of all rows, and one in the middle.
  std::vector<float> values(36, 0.0F);
  for (std::size_t row = 0; row < 9; ++row) values[4 * row] = 1;
  values[4 * 4 + 2] = 1;
  const ScalarField field = dense_field(values, {4, 3, 3});
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 3U * (9 + 2));
  EXPECT_EQ(estimate_surface(field, 0.5).boundary, 9U) << "the inner sample is on no face";
  const IndexBox box{{1, 0, 1}, {3, 1, 1}};
  EXPECT_EQ(estimate_surface(field, 0.5, box).vertices, 3U * 2);
  EXPECT_EQ(estimate_surface(field, 0.5, box).boundary, 1U);
  EXPECT_EQ(estimate_surface(field, 0.5, IndexBox{{-5, -5, -5}, {9, 9, 9}}).boundary, 9U);
  EXPECT_EQ(estimate_surface(field, 0.5, IndexBox{{5, 0, 0}, {9, 9, 9}}).vertices, 0U);
  values[1] = std::numeric_limits<float>::quiet_NaN();
  const ScalarField holed = dense_field(values, {4, 3, 3});
  EXPECT_TRUE(estimate_surface(holed, 0.5).has_nan);
  EXPECT_FALSE(estimate_surface(holed, 0.5, box).has_nan);
}

TEST(EstimateVertices, IsCloseForABall) {
  constexpr int kSize = 48;
  std::vector<float> values;
  for (int z = 0; z < kSize; ++z) {
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        values.push_back(20.0F - std::hypot(static_cast<float>(x) - 23.5F, static_cast<float>(y) - 23.5F,
                                            static_cast<float>(z) - 23.5F));
      }
    }
  }
  // Each line along an axis that meets the ball crosses it twice: 3 * 2 * pi * r^2.
  EXPECT_NEAR(static_cast<double>(estimate_surface(dense_field(values, glm::ivec3(kSize)), 0).vertices),
              6 * 3.14159 * 400, 6 * 3.14159 * 400 * 0.02);
}

// Blocks of zeros with samples of 1 at `ones`; the background is 0.
ScalarField blocks_with(const std::vector<std::pair<glm::ivec3, std::vector<glm::ivec3>>>& ones) {
  auto values = std::make_shared<std::vector<float>>(512 * ones.size(), 0.0F);
  SparseSamples sparse;
  sparse.type = SampleType::f32;
  sparse.owner = values;
  for (std::size_t b = 0; b < ones.size(); ++b) {
    sparse.blocks.push_back({ones[b].first, values->data() + 512 * b});
    for (const glm::ivec3& p : ones[b].second) {
      (*values)[512 * b + static_cast<std::size_t>(p.x << 6 | p.y << 3 | p.z)] = 1;
    }
  }
  ScalarField field;
  field.samples = std::move(sparse);
  return field;
}

// A sheet at one side of a block: 64 edges enter it on one side, 64 on the other, and 32 at its rim.
TEST(EstimateVertices, CountsBlockEdgesAlongEveryAxis) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<glm::ivec3> sheet;
    for (int a = 0; a < 8; ++a) {
      for (int b = 0; b < 8; ++b) {
        glm::ivec3 p(a, b, 0);
        std::swap(p.z, p[axis]);
        sheet.push_back(p);
      }
    }
    EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), sheet}}), 0.5).vertices, 64U + 64 + 4 * 8) << axis;
  }
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {glm::ivec3(3)}}}), 0.5).vertices, 6U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {}}}), 0.5).vertices, 0U);
}

// Tiles of 1 in a background of 0: edges inside do not cross, all edges at the faces do.
TEST(EstimateVertices, CountsFacesOfTiles) {
  ScalarField field = blocks_with({});
  auto& sparse = std::get<SparseSamples>(field.samples);
  sparse.tiles = {{glm::ivec3(0), 128, 1}};
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 6U * 128 * 128);
  EXPECT_EQ(estimate_surface(field, 0.5).places, 6U * 16 * 16);
  EXPECT_EQ(estimate_surface(field, 2).vertices, 0U);
  sparse.tiles.push_back({glm::ivec3(128, 0, 0), 8, 1});  // shares a face
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 6U * 128 * 128 + 4U * 8 * 8);
  sparse.tiles.back().value = -1;  // outside, like the background
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 6U * 128 * 128);
  field.kind = FieldKind::level_set;  // only the tile of -1 is inside below -0.5
  EXPECT_EQ(estimate_surface(field, -0.5).vertices, 6U * 8 * 8);
}

// A block beside the tile; all its samples at the shared face but one are inside.
TEST(EstimateVertices, CountsEdgesBetweenTilesAndBlocks) {
  std::vector<glm::ivec3> ones;
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (int z = 0; z < 8; ++z) {
        if (glm::ivec3(x, y, z) != glm::ivec3(0, 3, 4)) ones.emplace_back(x, y, z);
      }
    }
  }
  ScalarField field = blocks_with({{glm::ivec3(8, 0, 0), ones}});
  std::get<SparseSamples>(field.samples).tiles = {{glm::ivec3(0), 8, 1}};
  // Five edges of that sample are in the block and one leads to the tile; each has five free faces.
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 5U + 1 + 10U * 64);
}

// The surface of a group of voxels has one vertex per free face, for any block boundaries.
TEST(EstimateVertices, DoesNotDependOnBlockBoundaries) {
  for (int start = 0; start < 8; ++start) {
    std::map<std::array<int, 3>, std::vector<glm::ivec3>> blocks;
    for (int n = 0; n < 6 * 6 * 6; ++n) {
      const glm::ivec3 p = start + glm::ivec3(n % 6, n / 6 % 6, n / 36);
      const glm::ivec3 origin = block_origin(p);
      blocks[{origin.x, origin.y, origin.z}].push_back(p - origin);
    }
    std::vector<std::pair<glm::ivec3, std::vector<glm::ivec3>>> listed;
    for (auto& [origin, ones] : blocks) listed.emplace_back(glm::ivec3(origin[0], origin[1], origin[2]), ones);
    EXPECT_EQ(estimate_surface(blocks_with(listed), 0.5).vertices, 6U * 36) << start;
  }
}

TEST(EstimatePlaces, CountsBlocksAndEmptyNeighbors) {
  EXPECT_EQ(estimate_surface(dense_field({0, 1}, {2, 1, 1}), 0.5).places, 0U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {}}}), 0.5).places, 0U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {glm::ivec3(3)}}}), 0.5).places, 1U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {{0, 3, 3}}}}), 0.5).places, 2U)
      << "itself, and one before along x";
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {{3, 0, 0}}}}), 0.5).places, 4U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {glm::ivec3(0)}}}), 0.5).places, 8U);
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {}}, {glm::ivec3(8, 0, 0), {{0, 3, 3}}}}), 0.5).places, 1U)
      << "what lies before is stored, and has nothing of its own";
  EXPECT_EQ(estimate_surface(blocks_with({{glm::ivec3(0), {glm::ivec3(3)}}}), 5).places, 0U);
}

// Returns the most memory that this process held at a time, in bytes.
std::int64_t most_memory() {
  rusage usage{};
  EXPECT_EQ(getrusage(RUSAGE_SELF, &usage), 0);
  return std::int64_t{usage.ru_maxrss} * 1024;
}

// The estimate reserves no memory. SparseLookup would take over 16 KiB for each of these tiles.
TEST(EstimateVertices, TakesLittleMemoryForScatteredTiles) {
  constexpr int kTiles = 20'000;
  SparseSamples sparse;
  for (int t = 0; t < kTiles; ++t) sparse.tiles.push_back({glm::ivec3(128 * (t % 100), 128 * (t / 100), 0), 8, 1.0});
  ScalarField field;
  field.samples = std::move(sparse);
  const std::int64_t before = most_memory();
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, kTiles * 6U * 8 * 8);
  EXPECT_LT(most_memory() - before, std::int64_t{64} << 20);
}

// Tiles of three sizes beside each other and beside a block.
TEST(EstimateVertices, FindsTilesOfAnySize) {
  ScalarField field = blocks_with({{glm::ivec3(-8, 0, 0), {glm::ivec3(3)}}});
  auto& sparse = std::get<SparseSamples>(field.samples);
  sparse.tiles = {{glm::ivec3(0), 128, 1.0}, {glm::ivec3(128, 0, 0), 8, 1.0}, {glm::ivec3(0, -16, 0), 16, 1.0}};
  // The two smaller tiles cover 64 and 256 edges of the large one, and the block's side of it is not inside.
  EXPECT_EQ(estimate_surface(field, 0.5).vertices, 6U + 6U * 128 * 128 + 4U * 64 + 4U * 256);
}

}  // namespace
}  // namespace isoextract::field

#include "field/coarsen.hpp"

#include <gtest/gtest.h>

#include "field/interpolant.hpp"
#include "support/fields.hpp"

namespace isoextract::field {
namespace {

// A linear field keeps its value at every world position.
TEST(Coarsen, KeepsLinearFieldInPlace) {
  const Affine frame{glm::dmat3(-2, 0.3, 0, 0.5, 1, 0.2, 0, -0.4, 0.1), glm::dvec3(5, -3, 2)};
  ScalarField field = test::dense_field<double>({17, 16, 9}, [](int i, int j, int k) { return i + 10 * j - 3 * k; });
  field.index_to_world = frame;
  for (const int factor : {2, 4}) {
    const ScalarField coarse = coarsen(field, factor, Context()).value();
    EXPECT_EQ(std::get<DenseSamples>(coarse.samples).dims, glm::ivec3(17, 16, 9) / factor);
    EXPECT_EQ(coarse.type(), SampleType::f64);
    const Interpolant interpolant(coarse, Interpolation::trilinear);
    Interpolant::Cursor at(interpolant);
    const glm::dvec3 p(0.7, 0.4, 0.9);
    const glm::dvec3 fine = frame.inverse()(coarse.index_to_world(p));
    EXPECT_NEAR(at(p).value, fine.x + 10 * fine.y - 3 * fine.z, 1e-9);
    EXPECT_NEAR(glm::length(coarse.index_to_file(p) - fine), 0, 1e-9);
  }
  EXPECT_EQ(coarsen(field, 8, Context()).error().code, ErrorCode::input) << "one sample along z";
}

TEST(Coarsen, SparseEqualsDenseInsideData) {
  const ScalarField dense = test::dense_field<std::int16_t>({64, 64, 64}, [](int i, int j, int k) {
    return i >= 16 && i < 48 && j < 32 ? 7 : std::max(0, 30 - std::abs(i - 30) - std::abs(j - 28) - k);
  });
  const ScalarField sparse = test::sparse_copy<std::int16_t>(dense, 0);
  for (const int factor : {2, 4, 8}) {
    const ScalarField a = coarsen(dense, factor, Context()).value();
    const ScalarField b = coarsen(sparse, factor, Context()).value();
    ASSERT_TRUE(std::holds_alternative<SparseSamples>(b.samples));
    EXPECT_EQ(b.type(), SampleType::f32);
    EXPECT_EQ(a.index_to_world, b.index_to_world);
    const Interpolant of_a(a, Interpolation::trilinear);
    const Interpolant of_b(b, Interpolation::trilinear);
    Interpolant::Cursor at_a(of_a);
    Interpolant::Cursor at_b(of_b);
    for (int i = 0; i < 64 / factor; ++i) {
      for (int j = 0; j < 64 / factor; ++j) {
        for (int k = 0; k < 64 / factor; ++k) ASSERT_EQ(at_a({i, j, k}).value, at_b({i, j, k}).value);
      }
    }
    EXPECT_EQ(at_b({-40, 0, 0}).value, 0);
  }
}

// Blocks at negative indices, and a tile large enough to stay a tile.
TEST(Coarsen, SparseKeepsTilesAndNegativeIndices) {
  SparseSamples samples;
  samples.type = SampleType::f32;
  const std::vector<float> ones(512, 1.0F);
  samples.blocks = {{glm::ivec3(-8), ones.data()}};
  samples.tiles = {{glm::ivec3(64), 64, 3.0}, {glm::ivec3(-64, 0, 0), 8, 5.0}};
  samples.background = 0.5;
  ScalarField field;
  field.samples = samples;
  const ScalarField coarse = coarsen(field, 2, Context()).value();
  const auto& result = std::get<SparseSamples>(coarse.samples);
  ASSERT_EQ(result.tiles.size(), 1U);
  EXPECT_EQ(result.tiles[0].origin, glm::ivec3(32));
  EXPECT_EQ(result.tiles[0].size, 32);
  const Interpolant interpolant(coarse, Interpolation::trilinear);
  Interpolant::Cursor at(interpolant);
  EXPECT_EQ(at({-1, -1, -1}).value, 1);
  EXPECT_EQ(at({-4, -4, -4}).value, 1);
  EXPECT_EQ(at({-5, -4, -4}).value, 0.5);
  EXPECT_EQ(at({-32, 0, 0}).value, 5);
  EXPECT_EQ(at({40, 40, 40}).value, 3);
  EXPECT_EQ(at({0, 0, 0}).value, 0.5);
}

TEST(Coarsen, EndsEarlyWhenCancelled) {
  const ScalarField dense = test::random_field<float>({16, 16, 16}, 3, 1000);
  for (const ScalarField& field : {dense, test::sparse_copy<float>(dense, 0)}) {
    const Context context;
    context.cancel();
    const auto made = coarsen(field, 2, context);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::cancelled);
    EXPECT_EQ(context.progress().done(), 0U);
  }
}

TEST(Coarsen, ReservesMemoryForSparseBlocks) {
  const auto made = coarsen(test::row_of_blocks(20, 128), 2, Context(MemoryBudget(100'000)));
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::out_of_memory);
}

// No tile may have the background's value, also not after both were rounded to f32.
TEST(Coarsen, RoundsTilesAsBackground) {
  SparseSamples samples;
  samples.type = SampleType::i32;
  samples.tiles = {{glm::ivec3(0), 64, 0x1p24 + 1}, {glm::ivec3(64, 0, 0), 64, 0x1p25 + 1}};
  samples.background = 0x1p24;
  ScalarField field;
  field.samples = samples;
  const ScalarField coarse = coarsen(field, 2, Context()).value();
  const auto& result = std::get<SparseSamples>(coarse.samples);
  EXPECT_EQ(result.background, 0x1p24);
  ASSERT_EQ(result.tiles.size(), 1U);
  EXPECT_EQ(result.tiles[0].origin, glm::ivec3(32, 0, 0));
  EXPECT_EQ(result.tiles[0].value, 0x1p25);
}

TEST(Coarsen, KeepsNameOfGrid) {
  ScalarField field = test::random_field<float>({4, 4, 4}, 1, 10);
  field.grids = 3;
  field.grid = "density[1]";
  const ScalarField coarse = coarsen(field, 2, Context()).value();
  EXPECT_EQ(coarse.grids, 3U);
  EXPECT_EQ(coarse.grid, "density[1]");
}

}  // namespace
}  // namespace isoextract::field

#include "field/point_samples.hpp"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/fields.hpp"

namespace isoextract::field {
namespace {

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

double linear(const glm::dvec3& p) { return 0.25 + 2 * p.x - 3 * p.y + 0.5 * p.z; }

// A field whose samples are linear() of their world position.
ScalarField linear_field(const glm::ivec3& dims, const Affine& index_to_world) {
  ScalarField field =
      test::dense_field<double>(dims, [&](int i, int j, int k) { return linear(index_to_world(glm::dvec3(i, j, k))); });
  field.index_to_world = index_to_world;
  return field;
}

std::vector<float> sampled(const ScalarField& field, const std::vector<glm::dvec3>& places, PointCounts* counts) {
  std::vector<float> values(places.size());
  const auto done = sample_points(field, places, values, 1, Context());
  EXPECT_TRUE(done) << done.error().message;
  if (done && counts != nullptr) *counts = *done;
  return values;
}

TEST(PointSamples, ReproducesLinearFunction) {
  Affine bent = scaling({0.5, 0.25, 2});
  bent.linear[1] += glm::dvec3(0.125, 0, 0.5);
  bent.offset = {100, -7, 3};
  const ScalarField field = linear_field({9, 11, 5}, bent);
  std::vector<glm::dvec3> places;
  for (int n = 0; n < 500; ++n) {
    places.push_back(bent(glm::dvec3(std::fmod(0.37 * n, 8.0), std::fmod(0.73 * n, 10.0), std::fmod(0.11 * n, 4.0))));
  }
  PointCounts counts;
  const std::vector<float> values = sampled(field, places, &counts);
  for (std::size_t n = 0; n < places.size(); ++n) {
    EXPECT_FLOAT_EQ(values[n], static_cast<float>(linear(places[n])));
  }
  EXPECT_EQ(counts.outside, 0U);
  EXPECT_EQ(counts.not_finite, 0U);
}

TEST(PointSamples, ClampsToBoxAndCountsOutside) {
  const ScalarField field = linear_field({3, 3, 3}, Affine());
  PointCounts counts;
  const std::vector<float> values = sampled(field, {{-5, 1, 1}, {2.0005, 1, 1}, {9, 9, -9}, {1, 1, 1}}, &counts);
  EXPECT_FLOAT_EQ(values[0], static_cast<float>(linear({0, 1, 1})));
  EXPECT_FLOAT_EQ(values[1], static_cast<float>(linear({2, 1, 1})));
  EXPECT_FLOAT_EQ(values[2], static_cast<float>(linear({2, 2, 0})));
  EXPECT_EQ(counts.outside, 2U);  // the second is only a rounding error outside
}

TEST(PointSamples, IgnoresSamplesOfWeightZero) {
  const ScalarField field =
      test::dense_field<float>({3, 2, 2}, [](int i, int, int) { return i == 2 ? kNotANumber : static_cast<float>(i); });
  PointCounts counts;
  const std::vector<float> values = sampled(field, {{1, 0.5, 0}, {0.5, 0, 1}, {1.25, 0, 0}}, &counts);
  EXPECT_EQ(values[0], 1);
  EXPECT_EQ(values[1], 0.5F);
  EXPECT_TRUE(std::isnan(values[2]));
  EXPECT_EQ(counts.not_finite, 1U);
}

TEST(PointSamples, SamplesSingleLayer) {
  ScalarField field = test::dense_field<float>({2, 2, 1}, [](int i, int, int) { return static_cast<float>(i); });
  field.scale = {10, 1};
  PointCounts counts;
  EXPECT_EQ(sampled(field, {{0.5, 0.5, 0}, {1, 1, 0}}, &counts), (std::vector<float>{6, 11}));
  EXPECT_EQ(counts.outside, 0U);
}

TEST(PointSamples, SparseReturnsBackgroundOutsideBlocks) {
  std::vector<float> values(512, 3);
  ScalarField field;
  SparseSamples sparse;
  sparse.blocks = {{glm::ivec3(8, 0, -8), values.data()}};
  sparse.tiles = {{glm::ivec3(16, 0, -8), 8, 5.0}};
  sparse.background = -1;
  field.samples = sparse;
  PointCounts counts;
  EXPECT_EQ(
      sampled(field, {{8, 0, -8}, {15.5, 4, -4}, {20, 4, -4}, {7.5, 4, -4}, {1e300, 0, 0}, {-1e12, 4, 4}}, &counts),
      (std::vector<float>{3, 4, 5, 1, -1, -1}));
  EXPECT_EQ(counts.outside, 0U);
}

TEST(PointSamples, WritesOnlyStridedElementsForAnyThreads) {
  const ScalarField field = test::random_field<float>({20, 21, 22}, 1, 60000);
  std::vector<glm::dvec3> places;
  for (int n = 0; n < 20000; ++n) {
    places.emplace_back(std::fmod(0.377 * n, 19.0), std::fmod(0.173 * n, 20.0), std::fmod(0.711 * n, 21.0));
  }
  std::vector<float> several(3 * places.size(), 7);
  ASSERT_TRUE(sample_points(field, places, std::span(several).subspan(1), 3, Context()));
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<float> alone = sampled(field, places, nullptr);
  for (std::size_t n = 0; n < places.size(); ++n) {
    ASSERT_EQ(several[3 * n + 1], alone[n]);
    ASSERT_EQ(several[3 * n], 7);
    ASSERT_EQ(several[3 * n + 2], 7);
  }
}

TEST(PointSamples, ReservesMemoryForSparseBlocks) {
  std::vector<float> values(512, 3);
  ScalarField field;
  SparseSamples sparse;
  sparse.blocks = {{glm::ivec3(0), values.data()}};
  field.samples = sparse;
  const std::vector<glm::dvec3> places{{1, 1, 1}};
  std::vector<float> out(1);
  EXPECT_FALSE(sample_points(field, places, out, 1, Context{MemoryBudget(1000)}));
}

TEST(PointSamples, GivesNanAtNan) {
  const ScalarField dense = test::random_field<float>({8, 8, 8}, 1, 10);
  for (const ScalarField& field : {dense, test::sparse_copy<float>(dense, 0)}) {
    PointCounts counts;
    const std::vector<float> values = sampled(field, {{1, 1, 1}, {1, test::kNaN, 1}}, &counts);
    EXPECT_FALSE(std::isnan(values[0]));
    EXPECT_TRUE(std::isnan(values[1]));
    EXPECT_EQ(counts.not_finite, 1U);
    EXPECT_EQ(counts.outside, 0U);
  }
}

}  // namespace
}  // namespace isoextract::field

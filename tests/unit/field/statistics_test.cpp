#include "field/statistics.hpp"

#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/demo_field.hpp"

namespace isoextract::field {
namespace {

template <class T>
ScalarField dense_field(std::vector<T> values, glm::ivec3 dims = glm::ivec3(0)) {
  if (dims.x == 0) dims = {static_cast<int>(values.size()), 1, 1};
  auto owner = std::make_shared<std::vector<T>>(std::move(values));
  ScalarField field;
  field.samples = DenseSamples{sample_type_of<T>(), dims, owner, owner->data()};
  return field;
}

template <class T>
FieldStatistics statistics_of(std::vector<T> values) {
  return measure_statistics(dense_field(std::move(values)));
}

std::uint64_t histogram_sum(const FieldStatistics& statistics) {
  return std::accumulate(statistics.histogram.begin(), statistics.histogram.end(), std::uint64_t{0});
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kFloatInfinity = std::numeric_limits<float>::infinity();

TEST(Statistics, EveryTypeGivesExactRangeAndMean) {
  for (const SampleType type : {SampleType::u8, SampleType::i8, SampleType::u16, SampleType::i16, SampleType::u32,
                                SampleType::i32, SampleType::f16, SampleType::f32, SampleType::f64}) {
    visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
      std::vector<T> values;
      for (int i = 0; i < 101; ++i) values.push_back(static_cast<T>(static_cast<float>(i)));  // 101: not whole lanes
      const FieldStatistics statistics = statistics_of(values);
      EXPECT_EQ(statistics.samples, 101U) << sample_type_name(type);
      EXPECT_EQ(statistics.min, 0);
      EXPECT_EQ(statistics.max, 100);
      EXPECT_NEAR(statistics.mean, 50, 1e-12);
      EXPECT_EQ(histogram_sum(statistics), 101U);
    });
  }
}

TEST(Statistics, IntegersOf32BitsKeepAllTheirDigits) {
  const FieldStatistics statistics = statistics_of<std::int32_t>(std::vector<std::int32_t>(16, 2147483647));
  EXPECT_EQ(statistics.min, 2147483647.0);
  EXPECT_EQ(statistics.max, 2147483647.0);
}

TEST(Statistics, ValuesAreScaled) {
  ScalarField field = dense_field<std::uint8_t>({0, 10, 20});
  field.scale = {-2, 5};
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, -35);
  EXPECT_EQ(statistics.max, 5);
  EXPECT_NEAR(statistics.mean, -15, 1e-12);
}

TEST(Statistics, WhatIsNotFiniteIsCountedAndLeftOut) {
  std::vector<float> values(1000, 1.0F);
  values[0] = kNan;
  values[500] = kFloatInfinity;
  values[501] = -kFloatInfinity;
  values[999] = kNan;
  values.push_back(kFloatInfinity);  // alone in the rest that fills no lanes
  values[7] = -3.0F;
  const FieldStatistics statistics = statistics_of(values);
  EXPECT_EQ(statistics.nan, 2U);
  EXPECT_EQ(statistics.infinite, 3U);
  EXPECT_EQ(statistics.samples, 996U);
  EXPECT_EQ(statistics.min, -3);
  EXPECT_EQ(statistics.max, 1);
  EXPECT_EQ(histogram_sum(statistics), 996U);
}

TEST(Statistics, AllNanHasNoHistogram) {
  const ScalarField field = dense_field<float>(std::vector<float>(20, kNan));
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.samples, 0U);
  EXPECT_EQ(statistics.nan, 20U);
  EXPECT_TRUE(statistics.histogram.empty());
  EXPECT_TRUE(std::isfinite(suggest_iso(field, statistics).iso));
}

TEST(Statistics, ConstantField) {
  const ScalarField field = dense_field<double>(std::vector<double>(20, 7.25));
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, 7.25);
  EXPECT_EQ(statistics.max, 7.25);
  EXPECT_EQ(statistics.mean, 7.25);
  EXPECT_EQ(statistics.percentile(0.5), 7.25);
  EXPECT_EQ(histogram_sum(statistics), 20U);
  EXPECT_EQ(suggest_iso(field, statistics).iso, 7.25);
}

TEST(Statistics, TheWidestRangesDoNotOverflow) {
  const ScalarField field = dense_field<double>({-1.7e308, 1.7e308, 1.7e308, -1.7e308, 1.6e308, -1.6e308});
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, -1.7e308);
  EXPECT_EQ(statistics.max, 1.7e308);
  EXPECT_NEAR(statistics.mean / 1e308, 0, 1e-12);
  EXPECT_EQ(histogram_sum(statistics), 6U);
  EXPECT_EQ(statistics.histogram.front(), 2U);
  EXPECT_EQ(statistics.histogram.back(), 2U);
  EXPECT_TRUE(std::isfinite(statistics.percentile(0.3)));
  const double iso = suggest_iso(field, statistics).iso;
  EXPECT_GT(iso, -1.6e308);
  EXPECT_LT(iso, 1.6e308);

  const FieldStatistics floats = statistics_of<float>({-3e38F, 3e38F, 3e38F, 3e38F});
  EXPECT_NEAR(floats.mean, 1.5e38, 1e33);
}

TEST(Statistics, SubnormalRangeFillsTheHistogram) {
  const FieldStatistics statistics = statistics_of<double>({0, 5e-324, 1e-323});
  EXPECT_EQ(statistics.histogram.front(), 1U);
  EXPECT_EQ(statistics.histogram[512], 1U);
  EXPECT_EQ(statistics.histogram.back(), 1U);
}

TEST(Statistics, PercentilesAreRightToABin) {
  std::vector<float> values;
  for (int i = 0; i < 10000; ++i) values.push_back(static_cast<float>((i * 7919) % 10000));
  const FieldStatistics statistics = statistics_of(values);
  const double bin = 10000.0 / 1024;
  for (const double fraction : {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99}) {
    EXPECT_NEAR(statistics.percentile(fraction), fraction * 10000, bin);
  }
  EXPECT_EQ(statistics.percentile(0), 0);
  EXPECT_EQ(statistics.percentile(1), 9999);
}

TEST(Statistics, SparseCountsBlocksAndTilesButNotTheBackground) {
  auto block = std::make_shared<std::vector<float>>(512, 2.0F);
  (*block)[3] = 4.0F;
  SparseSamples sparse;
  sparse.type = SampleType::f32;
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.tiles = {SparseTile{glm::ivec3(8, 0, 0), 8, -1.0}, SparseTile{glm::ivec3(4096, 0, 0), 4096, 1.0}};
  sparse.background = 100;
  sparse.owner = block;
  ScalarField field;
  field.samples = sparse;
  const FieldStatistics statistics = measure_statistics(field);
  const std::uint64_t tile = std::uint64_t{1} << 36U;
  EXPECT_EQ(statistics.samples, 512 + 512 + tile);
  EXPECT_EQ(statistics.min, -1);
  EXPECT_EQ(statistics.max, 4);
  EXPECT_EQ(statistics.histogram.front(), 512U);
  EXPECT_EQ(statistics.histogram.back(), 1U);
}

TEST(Statistics, TheSameForAnyNumberOfThreads) {
  std::vector<float> values(1'000'000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<float>(i) * 0.37F) * 1e3F;
  const ScalarField field = dense_field(values);
  FieldStatistics first;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    first = measure_statistics(field);
  }
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  const FieldStatistics second = measure_statistics(field);
  EXPECT_EQ(first.mean, second.mean);
  EXPECT_EQ(first.histogram, second.histogram);
}

TEST(SuggestIso, TwoPeaksAreSeparatedInTheMiddleOfTheGap) {
  std::vector<float> values(100, 10.0F);
  values.insert(values.end(), 50, 90.0F);
  const ScalarField field = dense_field(values);
  EXPECT_NEAR(suggest_iso(field, measure_statistics(field)).iso, 50, 0.5);
}

TEST(SuggestIso, HasNoMoreDigitsThanABinJustifies) {
  const ScalarField field = dense_field<std::uint8_t>({0, 0, 0, 0, 1, 3, 250, 254, 254});
  const double iso = suggest_iso(field, measure_statistics(field)).iso;
  EXPECT_EQ(iso, std::round(iso * 10) / 10);
  EXPECT_GT(iso, 3);
  EXPECT_LT(iso, 250);
}

TEST(SuggestIso, LevelSetsHaveTheirZero) {
  ScalarField field = dense_field<float>({-0.5F, 3.0F, 3.0F});
  field.kind = FieldKind::level_set;
  const IsoSuggestion suggestion = suggest_iso(field, measure_statistics(field));
  EXPECT_EQ(suggestion.iso, 0);
  EXPECT_NE(suggestion.method.find("level set"), std::string::npos);
}

TEST(SuggestIso, DemoFieldsHaveTheirOwn) {
  const auto field = make_demo_field("demo:marschner-lobb?size=16");
  ASSERT_TRUE(field.has_value());
  EXPECT_EQ(suggest_iso(*field, measure_statistics(*field)).iso, 0.5);
}

TEST(EstimateVertices, CountsCrossingsWithinRowsOnly) {
  // Two rows of four: inside runs end at the rows' borders, which is no crossing.
  const ScalarField field = dense_field<float>({0, 0, 1, 1, 0, 1, 1, 0}, {4, 2, 1});
  EXPECT_EQ(estimate_vertices(field, 0.5), 3U * 3U);
  EXPECT_EQ(estimate_vertices(field, 1), 0U);  // a value equal to iso is outside
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
  // Every line along an axis that meets the ball crosses it twice: 3 * 2 * pi * r^2.
  EXPECT_NEAR(static_cast<double>(estimate_vertices(dense_field(values, glm::ivec3(kSize)), 0)), 6 * 3.14159 * 400,
              6 * 3.14159 * 400 * 0.02);
}

}  // namespace
}  // namespace isoextract::field

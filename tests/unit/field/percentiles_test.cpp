#include "field/percentiles.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/statistics.hpp"

namespace isoextract::field {
namespace {

Percent percent(std::string_view text) {
  const auto parsed = Percent::parse(text);
  EXPECT_TRUE(parsed) << text;
  return parsed.value_or(Percent());
}

template <class T>
ScalarField row_of(std::vector<T> values) {
  auto owner = std::make_shared<std::vector<T>>(std::move(values));
  ScalarField field;
  field.samples = DenseSamples{sample_type_of<T>(), {static_cast<int>(owner->size()), 1, 1}, owner, owner->data()};
  return field;
}

TEST(Percent, ParsesOnlyDecimals) {
  for (const auto& [text, shortest] :
       {std::pair("99", "99"), std::pair("0.5", "0.5"), std::pair("099.90", "99.9"), std::pair("0", "0"),
        std::pair("100.000000", "100"), std::pair("12.345678", "12.345678"), std::pair("0.000001", "0.000001")}) {
    EXPECT_EQ(percent(text).text(), shortest);
    EXPECT_EQ(percent(shortest), percent(text));
  }
  for (const char* text : {"", ".", ".5", "5.", "-1", "+1", "1e1", "100.000001", "101", "0.0000001", "9 9", "99%",
                           "nan", "1.2.3", "99999999999999999999", "0x5"}) {
    EXPECT_FALSE(Percent::parse(text)) << text;
  }
  EXPECT_EQ(percent("7"), Percent(7));
  EXPECT_LT(percent("99.8"), percent("99.9"));
}

// 99.9 % of 1000 are exactly 999 samples; the smallest larger share needs one more.
TEST(Percent, RanksAreExactForDecimals) {
  EXPECT_EQ(percent("99.9").rank_among(1000), 998U);
  EXPECT_EQ(percent("99.900001").rank_among(1000), 999U);
  EXPECT_EQ(percent("0").rank_among(1000), 0U);
  EXPECT_EQ(percent("0.05").rank_among(1000), 0U);
  EXPECT_EQ(percent("100").rank_among(1000), 999U);
  EXPECT_EQ(percent("50").rank_among(1), 0U);
  const std::uint64_t many = std::uint64_t{1} << 62U;
  EXPECT_EQ(percent("50").rank_among(many), many / 2 - 1);
  EXPECT_EQ(percent("100").rank_among(many), many - 1);
}

// Compares with sorted samples, for every type and for more percentiles than one pass finds.
TEST(MeasurePercentiles, ReturnsSamplesByRank) {
  const std::vector<Percent> asked{percent("50"),  percent("0"),    percent("100"), percent("99.9"),
                                   percent("0.5"), percent("33.3"), percent("50"),  percent("1"),
                                   percent("2"),   percent("3"),    percent("97"),  percent("98")};
  for (const double slope : {1.0, -0.5}) {
    for (const SampleType type : {SampleType::u8, SampleType::i16, SampleType::f16, SampleType::i32, SampleType::u32,
                                  SampleType::f32, SampleType::f64}) {
      visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
        std::mt19937 random(7);
        std::vector<T> stored;
        for (int i = 0; i < 1001; ++i) stored.push_back(static_cast<T>(static_cast<float>(random() % 120U)));
        ScalarField field = row_of(stored);
        field.scale = {slope, 3};
        std::vector<double> ordered;
        for (const T one : stored) ordered.push_back(field.scale(static_cast<double>(one)));
        std::ranges::sort(ordered);
        const auto found = measure_percentiles(field, asked);
        ASSERT_TRUE(found);
        ASSERT_EQ(found->size(), asked.size());
        for (std::size_t p = 0; p < asked.size(); ++p) {
          EXPECT_EQ((*found)[p], ordered[asked[p].rank_among(ordered.size())])
              << sample_type_name(type) << " p" << asked[p].text();
        }
      });
    }
  }
}

TEST(MeasurePercentiles, EqualsStatistics) {
  std::vector<float> values(100'000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<float>(i) * 0.37F) * 1e3F;
  values[5] = std::numeric_limits<float>::quiet_NaN();
  values[6] = std::numeric_limits<float>::infinity();
  const ScalarField field = row_of(values);
  std::vector<Percent> asked;
  for (const int whole : FieldStatistics::kPercents) asked.emplace_back(static_cast<std::uint32_t>(whole));
  const auto wide = measure_percentiles(field, asked);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto narrow = measure_percentiles(field, asked);
  ASSERT_TRUE(wide);
  EXPECT_EQ(*wide, *narrow);
  const FieldStatistics told = measure_statistics(field);
  EXPECT_TRUE(std::ranges::equal(*wide, told.percentiles));
  const FieldStatistics without = measure_statistics(field, nullptr, WithPercentiles::no);
  EXPECT_EQ(without.histogram, told.histogram);
  EXPECT_EQ(without.percentiles.back(), 0);
}

TEST(MeasurePercentiles, CountsTilesButNotBackground) {
  auto block = std::make_shared<std::vector<float>>(512, 2.0F);
  SparseSamples sparse;
  sparse.type = SampleType::f32;
  sparse.background = 100;
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.tiles = {SparseTile{glm::ivec3(8, 0, 0), 8, -1.0}, SparseTile{glm::ivec3(16, 0, 0), 8, -1.0}};
  sparse.owner = block;
  ScalarField field;
  field.samples = sparse;
  const std::vector<Percent> asked{percent("66.6"), percent("66.7"), percent("100")};
  EXPECT_EQ(measure_percentiles(field, asked), (std::vector<double>{-1, 2, 2}));
}

TEST(MeasurePercentiles, ReturnsNothingWithoutFiniteSamples) {
  const std::vector<Percent> asked{percent("50")};
  EXPECT_FALSE(measure_percentiles(row_of(std::vector<float>(9, std::nanf(""))), asked));
  EXPECT_FALSE(measure_percentiles(row_of(std::vector<Half>(9, Half(std::nanf("")))), asked));
  ScalarField none;
  none.samples = SparseSamples{};
  EXPECT_FALSE(measure_percentiles(none, asked));
}

}  // namespace
}  // namespace isoextract::field

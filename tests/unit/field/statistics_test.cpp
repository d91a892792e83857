#include "field/statistics.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/demo_field.hpp"
#include "field/percentiles.hpp"

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

TEST(Statistics, RangeAndMeanAreExactForEveryType) {
  for (const SampleType type : {SampleType::u8, SampleType::i8, SampleType::u16, SampleType::i16, SampleType::u32,
                                SampleType::i32, SampleType::f16, SampleType::f32, SampleType::f64}) {
    visit_sample_type(type, [&]<class T>(std::type_identity<T>) {
      std::vector<T> values;
      // 101 is not a multiple of the lanes.
      for (int i = 0; i < 101; ++i) values.push_back(static_cast<T>(static_cast<float>(i)));
      const FieldStatistics statistics = statistics_of(values);
      EXPECT_EQ(statistics.samples, 101U) << sample_type_name(type);
      EXPECT_EQ(statistics.min, 0);
      EXPECT_EQ(statistics.max, 100);
      EXPECT_NEAR(statistics.mean, 50, 1e-12);
      EXPECT_EQ(histogram_sum(statistics), 101U);
    });
  }
}

TEST(Statistics, KeepsAllDigitsOf32BitIntegers) {
  const FieldStatistics statistics = statistics_of<std::int32_t>(std::vector<std::int32_t>(16, 2147483647));
  EXPECT_EQ(statistics.min, 2147483647.0);
  EXPECT_EQ(statistics.max, 2147483647.0);
}

TEST(Statistics, ScalesValues) {
  ScalarField field = dense_field<std::uint8_t>({0, 10, 20});
  field.scale = {-2, 5};
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, -35);
  EXPECT_EQ(statistics.max, 5);
  EXPECT_NEAR(statistics.mean, -15, 1e-12);
}

TEST(Statistics, CountsNonFiniteSamplesAndLeavesThemOut) {
  std::vector<float> values(1000, 1.0F);
  values[0] = kNan;
  values[500] = kFloatInfinity;
  values[501] = -kFloatInfinity;
  values[999] = kNan;
  values.push_back(kFloatInfinity);  // alone in the rest that does not fill the lanes
  values[7] = -3.0F;
  const FieldStatistics statistics = statistics_of(values);
  EXPECT_EQ(statistics.nan, 2U);
  EXPECT_EQ(statistics.infinite, 3U);
  EXPECT_EQ(statistics.samples, 996U);
  EXPECT_EQ(statistics.min, -3);
  EXPECT_EQ(statistics.max, 1);
  EXPECT_EQ(histogram_sum(statistics), 996U);
}

TEST(Statistics, HasNoHistogramIfAllAreNan) {
  const ScalarField field = dense_field<float>(std::vector<float>(20, kNan));
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.samples, 0U);
  EXPECT_EQ(statistics.nan, 20U);
  EXPECT_TRUE(statistics.histogram.empty());
  EXPECT_FALSE(suggest_iso(field, statistics).separates);
}

TEST(Statistics, DescribesConstantField) {
  const ScalarField field = dense_field<double>(std::vector<double>(20, 7.25));
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, 7.25);
  EXPECT_EQ(statistics.max, 7.25);
  EXPECT_EQ(statistics.mean, 7.25);
  for (const double percentile : statistics.percentiles) EXPECT_EQ(percentile, 7.25);
  EXPECT_EQ(histogram_sum(statistics), 20U);
  EXPECT_EQ(suggest_iso(field, statistics).iso, 7.25);
  EXPECT_FALSE(suggest_iso(field, statistics).separates);
}

TEST(Statistics, WidestRangesDoNotOverflow) {
  const ScalarField field = dense_field<double>({-1.7e308, 1.7e308, 1.7e308, -1.7e308, 1.6e308, -1.6e308});
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.min, -1.7e308);
  EXPECT_EQ(statistics.max, 1.7e308);
  EXPECT_NEAR(statistics.mean / 1e308, 0, 1e-12);
  EXPECT_EQ(histogram_sum(statistics), 6U);
  EXPECT_EQ(statistics.histogram.front(), 2U);
  EXPECT_EQ(statistics.histogram.back(), 2U);
  for (const double percentile : statistics.percentiles) EXPECT_TRUE(std::isfinite(percentile));
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

// Returns the finite scaled values in ascending order.
template <class T>
std::vector<double> in_order(const std::vector<T>& stored, const ValueScale& scale) {
  std::vector<double> values;
  for (const T one : stored) {
    const double value = scale(static_cast<double>(one));
    if (std::isfinite(value)) values.push_back(value);
  }
  std::ranges::sort(values);
  return values;
}

template <class T>
void expect_exact_percentiles(const ScalarField& field, const std::vector<double>& ordered) {
  const FieldStatistics statistics = measure_statistics(field);
  ASSERT_EQ(statistics.samples, ordered.size());
  for (std::size_t p = 0; p < FieldStatistics::kPercents.size(); ++p) {
    const auto percent = static_cast<std::size_t>(FieldStatistics::kPercents[p]);
    const std::size_t rank = (percent * ordered.size() + 99) / 100 - 1;
    EXPECT_EQ(statistics.percentiles[p], ordered[rank])
        << sample_type_name(sample_type_of<T>()) << ", " << percent << " % of " << ordered.size();
  }
}

template <class T>
class ExactPercentiles : public testing::Test {};
using SampleTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                   Half, float, double>;
TYPED_TEST_SUITE(ExactPercentiles, SampleTypes);

// Half of the samples are equal; the others cover the whole type, including its extremes.
TYPED_TEST(ExactPercentiles, EqualSortedSamples) {
  using T = TypeParam;
  std::mt19937_64 engine(5);
  for (const std::size_t count : {1U, 2U, 7U, 99U, 100U, 101U, 20011U, 200000U}) {
    std::vector<T> stored(count);
    for (T& one : stored) {
      const std::uint64_t any = engine();
      const bool common = engine() % 2 == 0;
      if constexpr (std::is_same_v<T, Half>) {
        one.setBits(static_cast<std::uint16_t>(common ? 0x3C00U : any));  // 1 is common
      } else if constexpr (std::is_floating_point_v<T>) {
        using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
        one = common ? T{0} : std::bit_cast<T>(static_cast<Bits>(any));  // of any size and sign, including NaN
      } else {
        one = common ? T{3} : static_cast<T>(any);
      }
    }
    if constexpr (!std::is_same_v<T, Half>) {
      stored.front() = std::numeric_limits<T>::max();
      stored.back() = std::numeric_limits<T>::lowest();
    }
    for (const ValueScale scale : {ValueScale{}, ValueScale{0.25, -3}, ValueScale{-2, 5}}) {
      ScalarField field = dense_field(stored);
      field.scale = scale;
      const std::vector<double> ordered = in_order(stored, scale);
      if (!ordered.empty()) expect_exact_percentiles<T>(field, ordered);
    }
  }
}

// The scale maps large numbers beyond the range of double.
TEST(Statistics, PercentilesLeaveOutNonFiniteIntegers) {
  const std::vector<std::int32_t> stored{1, 2, 3, 2000000000, -2000000000, 4};
  ScalarField field = dense_field(stored);
  field.scale = {1e300, 0};
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.infinite, 2U);
  EXPECT_EQ(statistics.percentiles.front(), 1e300);
  EXPECT_EQ(statistics.percentiles.back(), 4e300);
}

TEST(Statistics, PercentilesCountTiles) {
  auto block = std::make_shared<std::vector<std::int32_t>>(512, 70000);
  SparseSamples sparse;
  sparse.type = SampleType::i32;
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.tiles = {SparseTile{glm::ivec3(8, 0, 0), 8, -70000.0}, SparseTile{glm::ivec3(16, 0, 0), 8, -70000.0}};
  sparse.owner = block;
  ScalarField field;
  field.samples = sparse;
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.percentiles[3], -70000);
  EXPECT_EQ(statistics.percentiles[4], 70000);
}

TEST(Statistics, CountsBlocksAndTilesButNotBackground) {
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

// A scan with air, soft tissue and some bone, in Hounsfield units.
std::vector<std::int16_t> scan_samples(double air = -1000, double bone = 1000) {
  std::mt19937 random(4);
  std::vector<std::int16_t> samples;
  const auto add = [&](int count, double mean, double deviation) {
    std::normal_distribution<double> normal(mean, deviation);
    for (int n = 0; n < count; ++n) samples.push_back(static_cast<std::int16_t>(std::lround(normal(random))));
  };
  add(6000, air, 15);
  add(3500, 40, 40);
  add(500, bone, 180);
  return samples;
}

TEST(Statistics, ThreeClassesSeparateAirSoftTissueAndBone) {
  const ScalarField scan = dense_field(scan_samples());
  const FieldStatistics statistics = measure_statistics(scan);
  const auto isos = suggest_ct_isos(scan, statistics);
  ASSERT_TRUE(isos);
  // The variance between the classes by its definition, for all pairs of cuts.
  const auto& bins = statistics.histogram;
  const auto mean_of = [&](std::size_t from, std::size_t to) {
    double count = 0;
    double sum = 0;
    for (std::size_t i = from; i < to; ++i) {
      count += static_cast<double>(bins[i]);
      sum += static_cast<double>(bins[i] * i);
    }
    return std::pair(count, count > 0 ? sum / count : 0.0);
  };
  const double mean = mean_of(0, bins.size()).second;
  const auto variance = [&](std::size_t low, std::size_t high) {
    double sum = 0;
    for (const auto& [from, to] :
         {std::pair{std::size_t{0}, low}, std::pair{low, high}, std::pair{high, bins.size()}}) {
      const auto [count, of_class] = mean_of(from, to);
      sum += count * (of_class - mean) * (of_class - mean);
    }
    return sum;
  };
  const double width = (statistics.max - statistics.min) / static_cast<double>(bins.size());
  const auto cut_at = [&](double iso) { return static_cast<std::size_t>(std::lround((iso - statistics.min) / width)); };
  const double found = variance(cut_at(isos->skin), cut_at(isos->bone));
  double best = 0;
  for (std::size_t low = 1; low + 1 < bins.size(); low += 3) {
    for (std::size_t high = low + 1; high < bins.size(); high += 3) best = std::max(best, variance(low, high));
  }
  EXPECT_GE(found, 0.99999 * best);
  EXPECT_NEAR(isos->skin, -500, 60);
  EXPECT_NEAR(isos->bone, 400, 100);
}

TEST(Statistics, SuggestsSkinAndBoneOnlyForCtScans) {
  const auto is_scan = [](const ScalarField& field) {
    return suggest_ct_isos(field, measure_statistics(field)).has_value();
  };
  EXPECT_TRUE(is_scan(dense_field(scan_samples())));
  EXPECT_FALSE(is_scan(dense_field(scan_samples(-700)))) << "no peak near -1000";
  EXPECT_FALSE(is_scan(dense_field(scan_samples(-1000, 300)))) << "no value above 1000";
  std::vector<float> floats;
  std::vector<std::uint16_t> raised;
  for (const std::int16_t sample : scan_samples()) {
    floats.push_back(sample);
    raised.push_back(static_cast<std::uint16_t>(sample + 1100));
  }
  EXPECT_FALSE(is_scan(dense_field(floats)));
  ScalarField scaled = dense_field(raised);
  EXPECT_FALSE(is_scan(scaled));
  scaled.scale = {1, -1100};
  EXPECT_TRUE(is_scan(scaled));
  // Padding outside the circle of view changes nothing.
  std::vector<std::int16_t> padded = scan_samples();
  const ScalarField plain = dense_field(scan_samples());
  padded.insert(padded.end(), 5000, -2000);
  const ScalarField with_padding = dense_field(padded);
  const auto isos = suggest_ct_isos(with_padding, measure_statistics(with_padding));
  ASSERT_TRUE(isos);
  EXPECT_NEAR(isos->bone, suggest_ct_isos(plain, measure_statistics(plain))->bone, 10);
}

// A row of eight voxels, within one block or across two: the stored values differ, the field does not.
TEST(Statistics, DoesNotDependOnSparseBlockBoundaries) {
  const auto row_from = [](int start) {
    auto values = std::make_shared<std::vector<float>>(2 * 512, 0.0F);
    for (int x = start; x < start + 8; ++x) {
      (*values)[static_cast<std::size_t>(x / 8 * 512 + x % 8)] = 1.0F + static_cast<float>(x - start);
    }
    SparseSamples sparse;
    sparse.type = SampleType::f32;
    sparse.blocks = {SparseBlock{glm::ivec3(0), values->data()}};
    if (start > 0) sparse.blocks.push_back(SparseBlock{glm::ivec3(8, 0, 0), values->data() + 512});
    sparse.owner = values;
    ScalarField field;
    field.samples = sparse;
    return field;
  };
  for (const int start : {0, 3}) {
    const ScalarField field = row_from(start);
    const FieldStatistics statistics = measure_statistics(field);
    EXPECT_EQ(statistics.samples, 8U);
    EXPECT_EQ(statistics.min, 1);
    EXPECT_EQ(statistics.mean, 4.5);
    EXPECT_EQ(statistics.percentiles[3], 4) << "the fourth of eight is half of them";
    EXPECT_EQ(histogram_sum(statistics), 8U);
    EXPECT_EQ(measure_percentiles(field, std::array{Percent(25)})->front(), 2);
  }
}

// Far values of a level set only tell the side: their number depends on storage, not on the field.
TEST(Statistics, LeavesOutFarValuesOfLevelSet) {
  auto block = std::make_shared<std::vector<float>>(512, 3.0F);
  std::fill_n(block->begin(), 200, -3.0F);
  for (int i = 0; i < 5; ++i) (*block)[static_cast<std::size_t>(i) * 100] = static_cast<float>(i) - 2.0F;
  SparseSamples sparse;
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.tiles = {SparseTile{glm::ivec3(8, 0, 0), 8, -3.0}, SparseTile{glm::ivec3(4096, 0, 0), 4096, -3.0}};
  sparse.background = 3;
  sparse.owner = block;
  ScalarField field;
  field.kind = FieldKind::level_set;
  field.samples = sparse;
  const FieldStatistics statistics = measure_statistics(field);
  EXPECT_EQ(statistics.samples, 5U);
  EXPECT_EQ(statistics.min, -2);
  EXPECT_EQ(statistics.max, 2);
  EXPECT_EQ(statistics.percentiles[3], 0);
  EXPECT_EQ(measure_percentiles(field, std::array{Percent(25)})->front(), -1);
  EXPECT_TRUE(suggest_iso(field, statistics).separates);
  field.kind = FieldKind::density;  // in a density field -3 counts like any other value
  EXPECT_GT(measure_statistics(field).samples, std::uint64_t{1} << 36U);
}

TEST(Statistics, DoesNotDependOnThreads) {
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

TEST(SuggestIso, CutsMiddleOfGapBetweenTwoPeaks) {
  std::vector<float> values(100, 10.0F);
  values.insert(values.end(), 50, 90.0F);
  const ScalarField field = dense_field(values);
  EXPECT_NEAR(suggest_iso(field, measure_statistics(field)).iso, 50, 0.5);
}

TEST(SuggestIso, RoundsToWidthOfBin) {
  const ScalarField field = dense_field<std::uint8_t>({0, 0, 0, 0, 1, 3, 250, 254, 254});
  const double iso = suggest_iso(field, measure_statistics(field)).iso;
  EXPECT_EQ(iso, std::round(iso * 10) / 10);
  EXPECT_GT(iso, 3);
  EXPECT_LT(iso, 250);
}

TEST(SuggestIso, SuggestsZeroForLevelSets) {
  ScalarField field = dense_field<float>({-0.5F, 3.0F, 3.0F});
  field.kind = FieldKind::level_set;
  const IsoSuggestion suggestion = suggest_iso(field, measure_statistics(field));
  EXPECT_EQ(suggestion.iso, 0);
  EXPECT_NE(suggestion.method.find("level set"), std::string::npos);
  EXPECT_TRUE(suggestion.separates);
  for (const std::vector<float>& without : {std::vector<float>{0.5F, 3}, std::vector<float>{-2, -0.5F}}) {
    field.samples = dense_field<float>(without).samples;
    EXPECT_FALSE(suggest_iso(field, measure_statistics(field)).separates);
  }
}

// The statistics leave the background out, but the surface passes it.
TEST(SuggestIso, SeparatesSingleValueFromBackground) {
  auto block = std::make_shared<std::vector<float>>(512, 2.0F);
  SparseSamples sparse;
  sparse.type = SampleType::f32;
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.owner = block;
  ScalarField field;
  for (const double background : {0.0, 8.0, 2.0}) {
    sparse.background = background;
    field.samples = sparse;
    const IsoSuggestion suggestion = suggest_iso(field, measure_statistics(field));
    EXPECT_EQ(suggestion.iso, (2 + background) / 2);
    EXPECT_EQ(suggestion.separates, background != 2);
  }
}

TEST(SuggestIso, SuggestsIsoOfDemoField) {
  const auto field = make_demo_field("demo:marschner-lobb?size=16", Context());
  ASSERT_TRUE(field.has_value());
  EXPECT_EQ(suggest_iso(*field, measure_statistics(*field)).iso, 0.5);
}

// A block of 3 with samples of -3 and one of 1, and tiles, over 3.
template <class T>
ScalarField level_set_with(std::size_t inside, std::vector<SparseTile> tiles) {
  auto block = std::make_shared<std::vector<T>>(512, T(3.0F));
  std::fill_n(block->begin(), inside, T(-3.0F));
  (*block)[300] = T(1.0F);
  SparseSamples sparse;
  sparse.type = sample_type_of<T>();
  sparse.blocks = {SparseBlock{glm::ivec3(0), block->data()}};
  sparse.tiles = std::move(tiles);
  sparse.background = 3;
  sparse.owner = block;
  ScalarField field;
  field.kind = FieldKind::level_set;
  field.samples = sparse;
  return field;
}

// The statistics leave both far values of a level set out, but the surface passes between them.
TEST(SuggestIso, SeparatesFarInsideFromBackground) {
  const std::vector<SparseTile> tile{{glm::ivec3(8, 0, 0), 8, -3.0}};
  const std::vector<SparseTile> other_tile{{glm::ivec3(8, 0, 0), 8, 2.0}};
  for (const ScalarField& field : {level_set_with<float>(200, {}), level_set_with<Half>(200, {}),
                                   level_set_with<float>(0, tile), level_set_with<Half>(0, tile)}) {
    const FieldStatistics statistics = measure_statistics(field);
    EXPECT_EQ(statistics.samples, 1U);
    EXPECT_TRUE(suggest_iso(field, statistics).separates);
    const auto range = surface_range(field, statistics);
    ASSERT_TRUE(range);
    EXPECT_EQ(range->min, -3);
    EXPECT_EQ(range->max, 3);
  }
  for (const ScalarField& field : {level_set_with<float>(0, {}), level_set_with<Half>(0, other_tile)}) {
    EXPECT_FALSE(suggest_iso(field, measure_statistics(field)).separates) << "no sample is inside";
  }
  ScalarField scaled = level_set_with<float>(200, {});
  scaled.scale = {2, 10};
  EXPECT_EQ(surface_range(scaled, measure_statistics(scaled))->min, 4);
}

}  // namespace
}  // namespace isoextract::field

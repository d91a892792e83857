#include "field/blur.hpp"

#include <cmath>
#include <map>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/interpolant.hpp"
#include "support/fields.hpp"

namespace isoextract::field {
namespace {

double value_at(const ScalarField& field, const glm::ivec3& p) {
  return visit_sample_type(field.type(), [&]<class T>(std::type_identity<T>) {
    if (const auto* dense = std::get_if<DenseSamples>(&field.samples)) {
      const glm::i64vec3 dims(dense->dims);
      return static_cast<double>(static_cast<const T*>(dense->data)[p.x + dims.x * (p.y + dims.y * p.z)]);
    }
    const auto& sparse = std::get<SparseSamples>(field.samples);
    const SparseLookup lookup(sparse);
    const std::int32_t stored = lookup.place(block_origin(p));
    if (stored < 0) return lookup.constant_of(stored);
    return static_cast<double>(
        static_cast<const T*>(sparse.blocks[static_cast<std::size_t>(stored)].values)[block_offset(p)]);
  });
}

// The weighted mean that the header defines, summed directly.
double mean_around(const ScalarField& field, const glm::ivec3& dims, const glm::ivec3& p, const glm::dvec3& sigma) {
  double sum = 0;
  double weights = 0;
  const glm::ivec3 reach(glm::ceil(3.0 * sigma));
  for (int k = std::max(0, p.z - reach.z); k <= std::min(dims.z - 1, p.z + reach.z); ++k) {
    for (int j = std::max(0, p.y - reach.y); j <= std::min(dims.y - 1, p.y + reach.y); ++j) {
      for (int i = std::max(0, p.x - reach.x); i <= std::min(dims.x - 1, p.x + reach.x); ++i) {
        const double value = value_at(field, {i, j, k});
        if (!std::isfinite(value)) continue;
        double squares = 0;
        for (int axis = 0; axis < 3; ++axis) {
          const double away = glm::ivec3(i, j, k)[axis] - p[axis];
          if (sigma[axis] > 0) squares += away * away / (sigma[axis] * sigma[axis]);
        }
        sum += std::exp(-squares / 2) * value;
        weights += std::exp(-squares / 2);
      }
    }
  }
  return sum / weights;
}

template <class T>
class BlurTypes : public testing::Test {};
using Types = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, Half,
                             float, double>;
TYPED_TEST_SUITE(BlurTypes, Types);

TYPED_TEST(BlurTypes, GaussianIsWeightedMean) {
  const glm::ivec3 dims(19, 40, 11);
  const ScalarField field = test::random_field<TypeParam>(dims, 1, 100);
  const glm::dvec3 sigma(1.3, 0.8, 2.1);
  const ScalarField blurred = blur_gaussian(field, sigma, Context()).value();
  const bool wide = sizeof(TypeParam) == 8 || (std::is_integral_v<TypeParam> && sizeof(TypeParam) == 4);
  EXPECT_EQ(blurred.type(), wide ? SampleType::f64 : SampleType::f32);
  for (const glm::ivec3 p : {glm::ivec3(0), dims - 1, dims / 2, glm::ivec3(18, 0, 5), glm::ivec3(3, 33, 10)}) {
    EXPECT_NEAR(value_at(blurred, p), mean_around(field, dims, p, sigma), 1e-4);
  }
}

TYPED_TEST(BlurTypes, MedianIsMiddleValue) {
  const glm::ivec3 dims(9, 12, 7);
  const ScalarField field = test::random_field<TypeParam>(dims, 2, 100);
  const ScalarField blurred = blur_median(field, 1, Context()).value();
  EXPECT_EQ(blurred.type(), field.type());
  for (const glm::ivec3 p : {glm::ivec3(0), dims - 1, dims / 2, glm::ivec3(8, 0, 5), glm::ivec3(3, 11, 1)}) {
    std::vector<double> around;
    for (int k = std::max(0, p.z - 1); k <= std::min(dims.z - 1, p.z + 1); ++k) {
      for (int j = std::max(0, p.y - 1); j <= std::min(dims.y - 1, p.y + 1); ++j) {
        for (int i = std::max(0, p.x - 1); i <= std::min(dims.x - 1, p.x + 1); ++i) {
          around.push_back(value_at(field, {i, j, k}));
        }
      }
    }
    std::ranges::sort(around);
    EXPECT_EQ(value_at(blurred, p), around[(around.size() - 1) / 2]);
  }
}

TYPED_TEST(BlurTypes, SparseEqualsDenseInsideData) {
  // The field has blocks, tiles that differ from the background, and background.
  const ScalarField dense = test::dense_field<TypeParam>({64, 48, 40}, [](int i, int j, int k) {
    return i >= 24 && i < 48 && j < 32 ? 7 : std::max(0, 30 - std::abs(i - 30) - std::abs(j - 28) - k);
  });
  const ScalarField sparse = test::sparse_copy<TypeParam>(dense, 0);
  ASSERT_FALSE(std::get<SparseSamples>(sparse.samples).tiles.empty());
  const ScalarField a = blur_gaussian(dense, {1.5, 2, 3}, Context()).value();
  const ScalarField b = blur_gaussian(sparse, {1.5, 2, 3}, Context()).value();
  const ScalarField c = blur_median(dense, 2, Context()).value();
  const ScalarField d = blur_median(sparse, 2, Context()).value();
  ASSERT_TRUE(std::holds_alternative<SparseSamples>(b.samples));
  EXPECT_EQ(a.type(), b.type());
  for (int i = 9; i < 64 - 9; ++i) {
    for (int j = 9; j < 48 - 9; ++j) {
      for (int k = 9; k < 40 - 9; ++k) {
        ASSERT_NEAR(value_at(a, {i, j, k}), value_at(b, {i, j, k}), 1e-5) << i << ' ' << j << ' ' << k;
        ASSERT_EQ(value_at(c, {i, j, k}), value_at(d, {i, j, k}));
      }
    }
  }
  // Outside the data the background counts as an ordinary value.
  EXPECT_GT(value_at(b, {30, 28, -2}), 0);
  EXPECT_EQ(value_at(b, {30, 28, -100}), 0);
  EXPECT_EQ(std::get<SparseSamples>(b.samples).active_box, std::get<SparseSamples>(sparse.samples).active_box);
}

TEST(Blur, KeepsConstantsExactly) {
  for (const double value : {0.1, -3e38, 1e-40, 7.0}) {
    const ScalarField field = test::dense_field<float>({20, 9, 8}, [&](int, int, int) { return value; });
    const ScalarField blurred = blur_gaussian(field, glm::dvec3(2), Context()).value();
    for (int i = 0; i < 20; ++i) EXPECT_EQ(value_at(blurred, {i, 4, 3}), value_at(field, {i, 4, 3}));
  }
  const ScalarField extreme =
      test::dense_field<double>({20, 4, 4}, [](int i, int, int) { return i % 2 == 0 ? 1.7e308 : -1.7e308; });
  const ScalarField blurred = blur_gaussian(extreme, glm::dvec3(2), Context()).value();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(std::isfinite(value_at(blurred, {i, 1, 1})));
}

TEST(Blur, KeepsFactsAboutTheFieldsOrigin) {
  ScalarField field = test::dense_field<float>({8, 8, 8}, [](int i, int, int) { return i; });
  field.is_sampled = true;
  field.time = 2.5;
  field.time_unit = "s";
  for (const ScalarField& blurred :
       {blur_gaussian(field, glm::dvec3(1), Context()).value(), blur_median(field, 1, Context()).value()}) {
    EXPECT_TRUE(blurred.is_sampled);
    EXPECT_EQ(blurred.time, field.time);
    EXPECT_EQ(blurred.time_unit, "s");
  }
}

TEST(Blur, IgnoresAndKeepsNonFiniteSamples) {
  const double infinity = std::numeric_limits<double>::infinity();
  const glm::ivec3 dims(24, 16, 16);
  std::mt19937 engine(3);
  std::map<std::tuple<int, int, int>, double> odd;
  for (int n = 0; n < 60; ++n) {
    odd[{engine() % 24, engine() % 16, engine() % 16}] = n % 3 == 0 ? infinity : n % 3 == 1 ? -infinity : test::kNaN;
  }
  const ScalarField dense = test::dense_field<float>(dims, [&](int i, int j, int k) {
    const auto found = odd.find({i, j, k});
    return found != odd.end() ? found->second : i + 0.5 * j * j - k;
  });
  const glm::dvec3 sigma(1, 1.5, 0.7);
  const ScalarField blurred = blur_gaussian(dense, sigma, Context()).value();
  const ScalarField median = blur_median(dense, 1, Context()).value();
  for (int i = 0; i < dims.x; ++i) {
    for (int j = 0; j < dims.y; ++j) {
      for (int k = 0; k < dims.z; ++k) {
        const double was = value_at(dense, {i, j, k});
        const double is = value_at(blurred, {i, j, k});
        if (!std::isfinite(was)) {
          EXPECT_TRUE(std::isnan(was) ? std::isnan(is) : is == was);
          EXPECT_EQ(std::isnan(value_at(median, {i, j, k})), std::isnan(was));
        } else {
          ASSERT_NEAR(is, mean_around(dense, dims, {i, j, k}, sigma), 1e-4);
        }
      }
    }
  }
  // Sparse blocks give the same.
  const ScalarField sparse = blur_gaussian(test::sparse_copy<float>(dense, 0), sigma, Context()).value();
  for (int i = 6; i < dims.x - 6; ++i) {
    for (int j = 6; j < dims.y - 6; ++j) {
      for (int k = 6; k < dims.z - 6; ++k) {
        const double expected = value_at(blurred, {i, j, k});
        const double found = value_at(sparse, {i, j, k});
        if (std::isfinite(expected)) {
          ASSERT_NEAR(found, expected, 1e-4);
        } else {
          ASSERT_EQ(std::isnan(found), std::isnan(expected));
        }
      }
    }
  }
}

// Only the boundary of a large tile is blurred; the rest stays tiles.
TEST(Blur, SplitsLargeTilesAtTheirBoundary) {
  SparseSamples samples;
  samples.type = SampleType::f32;
  samples.tiles = {{glm::ivec3(-128), 128, 3.0}, {glm::ivec3(0, -128, -128), 128, 3.0}};
  samples.background = -1;
  ScalarField field;
  field.source = "tiles";
  field.samples = samples;
  const ScalarField blurred = blur_gaussian(field, glm::dvec3(2), Context()).value();
  const auto& result = std::get<SparseSamples>(blurred.samples);
  EXPECT_EQ(value_at(blurred, {-64, -64, -64}), 3);
  EXPECT_EQ(value_at(blurred, {0, -64, -64}), 3) << "between two tiles of one value nothing changes";
  EXPECT_LT(value_at(blurred, {-64, -64, -1}), 3);
  EXPECT_GT(value_at(blurred, {-64, -64, 0}), -1);
  EXPECT_NEAR(value_at(blurred, {-64, -64, -1}) + value_at(blurred, {-64, -64, 0}), 2, 1e-5);
  EXPECT_EQ(value_at(blurred, {-64, -64, 30}), -1);
  std::uint64_t samples_of_tiles = 0;
  for (const SparseTile& tile : result.tiles) {
    EXPECT_EQ(tile.value, 3);
    EXPECT_EQ(glm::ivec3(0), tile.origin & (tile.size - 1)) << "at a multiple of its size";
    samples_of_tiles += static_cast<std::uint64_t>(tile.size) * tile.size * tile.size;
  }
  // Places at least one block away from the boundary: 14 of 16 along y and z, 30 of 32 along x.
  EXPECT_EQ(samples_of_tiles, 512U * 30 * 14 * 14);
  const std::size_t shell = 34U * 18 * 18 - 30U * 14 * 14;
  EXPECT_EQ(result.blocks.size(), shell);
  for (const SparseBlock& block : result.blocks) {
    for (const SparseTile& tile : result.tiles) {
      const bool apart = glm::any(glm::lessThan(block.origin, tile.origin)) ||
                         glm::any(glm::greaterThanEqual(block.origin, tile.origin + tile.size));
      ASSERT_TRUE(apart);
    }
  }
}

TEST(Blur, DoesNotDependOnThreads) {
  const ScalarField field = test::random_field<float>({64, 40, 48}, 4, 1000);
  const ScalarField sparse = test::sparse_copy<float>(field, 0);
  for (const ScalarField* data : {&field, &sparse}) {
    std::vector<std::vector<double>> results(2);
    for (const std::size_t run : {0U, 1U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, run == 0 ? 1 : 4);
      const ScalarField blurred =
          blur_median(blur_gaussian(*data, glm::dvec3(1.7), Context()).value(), 1, Context()).value();
      for (int i = 0; i < 64; i += 3) results[run].push_back(value_at(blurred, {i, i / 2, 47 - i / 2}));
    }
    EXPECT_EQ(results[0], results[1]);
  }
}

TEST(Blur, RefusesInvalidSizesAndFailsCleanly) {
  const ScalarField field = test::random_field<float>({16, 16, 16}, 4, 1000);
  EXPECT_EQ(blur_gaussian(field, {1, 17, 1}, Context()).error().code, ErrorCode::usage);
  EXPECT_EQ(blur_gaussian(field, {1, test::kNaN, 1}, Context()).error().code, ErrorCode::usage);
  EXPECT_EQ(blur_median(field, 9, Context()).error().code, ErrorCode::usage);
  EXPECT_EQ(blur_median(field, 0, Context()).error().code, ErrorCode::usage);
  for (const ScalarField& data : {field, test::sparse_copy<float>(field, 0)}) {
    const Context little{MemoryBudget(1000)};
    EXPECT_EQ(blur_gaussian(data, glm::dvec3(1), little).error().hint, Hint(Remedy::raise, Setting::memory_limit));
    EXPECT_EQ(blur_median(data, 1, little).error().hint, Hint(Remedy::raise, Setting::memory_limit));
    const Context cancelled;
    cancelled.cancel();
    EXPECT_EQ(blur_gaussian(data, glm::dvec3(1), cancelled).error().code, ErrorCode::cancelled);
    EXPECT_EQ(blur_median(data, 1, cancelled).error().code, ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace isoextract::field

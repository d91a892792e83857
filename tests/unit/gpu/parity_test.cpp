// The GPU gives the mesh of the CPU: dense samples of every type, size, scale and transform.
#include <limits>

#include "drawings.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"

namespace isoextract::gpu {
namespace {

using test::expect_parity;

constexpr glm::ivec3 kSizes[] = {{2, 2, 2},   {3, 2, 2},    {2, 40, 2},  {2, 2, 33}, {8, 8, 8},    {9, 9, 9},
                                 {10, 9, 17}, {16, 16, 16}, {17, 8, 33}, {65, 3, 4}, {130, 10, 2}, {7, 24, 25}};

TEST(Parity, MatchesForOddSizes) {
  unsigned seed = 0;
  for (const glm::ivec3& dims : kSizes) {
    SCOPED_TRACE(testing::Message() << dims.x << " x " << dims.y << " x " << dims.z);
    extract::ExtractOptions options = test::at_iso(500000);
    options.cap = seed % 3 == 0;
    const field::ScalarField field = test::random_field<float>(dims, seed++, 1000000);
    EXPECT_GT(expect_parity(field, options, test::kAllDrawings), 0U);
    options.smooth_normals = true;
    EXPECT_GT(expect_parity(field, options), 0U);
  }
}

// Few distinct values: samples, faces and cells tie with iso.
TEST(Parity, MatchesForTies) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const field::ScalarField field = test::random_field<std::int16_t>({12, 11, 10}, seed, 5);
    for (const double iso : {0.0, 1.0, 2.0, 2.5}) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", iso " << iso);
      extract::ExtractOptions options = test::at_iso(iso);
      options.cap = seed % 2 == 1;
      EXPECT_GT(expect_parity(field, options, test::kAllDrawings), 0U);
    }
  }
}

TEST(Parity, FailsAlikeForAxesOfOneSample) {
  for (const glm::ivec3& dims : {glm::ivec3(1, 5, 5), glm::ivec3(5, 1, 5), glm::ivec3(5, 5, 1)}) {
    const field::ScalarField field = test::random_field<float>(dims, 1, 9);
    EXPECT_EQ(expect_parity(field, test::at_iso(4)), 0U);
    EXPECT_FALSE(test::kGpuExtractors->find({})->extract(field, test::at_iso(4), Context()));
  }
}

template <class T>
class ParityOfType : public testing::Test {};
using SampleTypes = testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t,
                                   field::Half, float, double>;
TYPED_TEST_SUITE(ParityOfType, SampleTypes);

// The whole range of the type, with scales of both signs, as density and as level set.
TYPED_TEST(ParityOfType, MatchesScaledOrNot) {
  using T = TypeParam;
  std::mt19937_64 engine(11);
  field::ScalarField field = test::dense_field<T>({11, 10, 12}, [&](int, int, int) {
    if constexpr (std::is_integral_v<T>) return static_cast<double>(static_cast<T>(engine()));
    return std::uniform_real_distribution<double>(-1000, 1000)(engine);
  });
  const double middle = std::is_unsigned_v<T> ? static_cast<double>(std::numeric_limits<T>::max()) * 0.4 : 1;
  for (const field::ValueScale& scale : {field::ValueScale{}, field::ValueScale{0.1, -3},
                                         field::ValueScale{-2.5e-7, 1e3}, field::ValueScale{-1e12, 0}}) {
    SCOPED_TRACE(testing::Message() << scale.slope << " * stored + " << scale.intercept);
    field.scale = scale;
    for (const field::FieldKind kind : {field::FieldKind::density, field::FieldKind::level_set}) {
      field.kind = kind;
      extract::ExtractOptions options = test::at_iso(scale(middle));
      options.smooth_normals = std::is_same_v<T, double> || std::is_same_v<T, std::int16_t>;
      EXPECT_GT(expect_parity(field, options), 0U);
    }
  }
}

TEST(Parity, MatchesForEveryPlacement) {
  const field::ScalarField field = test::random_field<float>({13, 12, 11}, 3, 1000000);
  const glm::dmat3 turned(0.8, 0.6, 0, -0.36, 0.48, 0.8, 0.48, -0.64, 0.6);
  const glm::dmat3 sheared(1, 0.25, 0, -0.5, 2, 0, 0.3, 0.125, 0.5);
  for (const field::Affine& frame :
       {field::scaling({-1, 1, 1}), field::scaling({1e-3, 40, 0.7}), field::Affine{turned, {1, 2, 3}},
        field::Affine{-turned, {1e7, -2e7, 3e7}}, field::Affine{sheared, {-1e5, 0, 1e6}}}) {
    extract::ExtractOptions options = test::at_iso(400000);
    options.output_from_index = frame;
    options.smooth_normals = true;
    options.cap = true;
    EXPECT_GT(expect_parity(field, options), 0U);
  }
}

TEST(Parity, MatchesForRegionsAndCaps) {
  const field::ScalarField field = test::random_field<std::uint16_t>({30, 21, 26}, 8, 1000);
  for (const field::IndexBox& region :
       {field::IndexBox{{3, 5, 2}, {20, 12, 9}}, field::IndexBox{{8, 8, 8}, {16, 16, 16}},
        field::IndexBox{{0, 0, 0}, {1, 1, 1}}, field::IndexBox{{28, 19, 24}, {29, 20, 25}},
        field::IndexBox{{1, 0, 25 - 9}, {2, 30, 40}}, field::IndexBox{{7, 7, 7}, {8, 8, 25}}}) {
    for (const bool cap : {false, true}) {
      SCOPED_TRACE(testing::Message() << "region from " << region.min.x << ", cap " << cap);
      extract::ExtractOptions options = test::at_iso(500);
      options.region = region;
      options.cap = cap;
      options.smooth_normals = true;
      expect_parity(field, options);
    }
  }
  extract::ExtractOptions options = test::at_iso(500);
  options.region = field::IndexBox{{40, 0, 0}, {50, 9, 9}};
  expect_parity(field, options);
  EXPECT_FALSE(test::kGpuExtractors->find({})->extract(field, options, Context()));
}

// Scattered NaN and infinities, also just inside the boundary that a cap closes.
TEST(Parity, MatchesForNanAndInfinities) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (unsigned seed = 0; seed < 4; ++seed) {
    std::mt19937 engine(seed);
    const auto value = [&](int, int, int) {
      const double random = std::uniform_real_distribution<double>(-1, 1)(engine);
      switch (std::uniform_int_distribution<int>(0, seed < 2 ? 30 : 200)(engine)) {
        case 0: return kNan;
        case 1: return -kNan;
        case 2: return kInfinity;
        case 3: return -kInfinity;
        default: return random;
      }
    };
    const glm::ivec3 dims(18, 17, 15);
    const field::ScalarField field = seed % 2 == 0 ? test::dense_field<float>(dims, value)
                                     : seed == 1   ? test::dense_field<double>(dims, value)
                                                   : test::dense_field<field::Half>(dims, value);
    for (const extract::NanPolicy policy :
         {extract::NanPolicy::error, extract::NanPolicy::outside, extract::NanPolicy::hole}) {
      for (const bool cap : {false, true}) {
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", policy " << static_cast<int>(policy) << ", cap "
                                        << cap);
        extract::ExtractOptions options = test::at_iso(0.1);
        options.nan = policy;
        options.cap = cap;
        options.smooth_normals = seed % 2 == 0;
        expect_parity(field, options);
      }
    }
  }
}

TEST(Parity, MatchesForEmptyAndFullFields) {
  for (const double value : {-1.0, 1.0}) {
    const field::ScalarField field = test::dense_field<float>({9, 20, 9}, [&](int, int, int) { return value; });
    extract::ExtractOptions options = test::at_iso(0);
    EXPECT_EQ(expect_parity(field, options), 0U);
    options.cap = true;
    EXPECT_EQ(expect_parity(field, options) > 0, value > 0);
  }
  // No number of the type is inside.
  EXPECT_EQ(expect_parity(test::random_field<std::uint8_t>({9, 9, 9}, 1, 256), test::at_iso(255)), 0U);
}

// Values whose differences exceed the range of float or double, or vanish in it.
TEST(Parity, MatchesForExtremeValues) {
  for (const double size : {1e-310, 5e-324, 1e-300, 1e-45, 1e30, 1e300, 1.7e308}) {
    SCOPED_TRACE(testing::Message() << "values about " << size);
    std::mt19937 engine(2);
    const field::ScalarField field = test::dense_field<double>({10, 9, 8}, [&](int, int, int) {
      return size * std::uniform_int_distribution<int>(-3, 3)(engine) / (size > 1e-320 ? 3 : 1);
    });
    EXPECT_GT(expect_parity(field, test::at_iso(0)), 0U);
    EXPECT_GT(expect_parity(field, test::at_iso(size > 1e-320 ? size / 3 : size)), 0U);
  }
  // Scales that turn ordinary samples into extreme values.
  for (const double slope : {1e-290, 1e-200, 1e305}) {
    SCOPED_TRACE(testing::Message() << "slope " << slope);
    field::ScalarField field = test::random_field<float>({10, 9, 8}, 4, 1000);
    field.scale = {slope, 0};
    EXPECT_GT(expect_parity(field, test::at_iso(500.5 * slope)), 0U);
  }
}

TEST(Parity, MatchesForDemoFields) {
  for (const char* spec : {"demo:sphere?size=40", "demo:gyroid?size=36", "demo:marschner-lobb?size=41"}) {
    SCOPED_TRACE(spec);
    const auto field = field::make_demo_field(spec, Context());
    ASSERT_TRUE(field);
    extract::ExtractOptions options =
        test::at_iso(std::string_view(spec).find("lobb") != std::string_view::npos ? 0.5 : 0);
    options.output_from_index = field->index_to_world;
    options.smooth_normals = true;
    options.cap = true;
    EXPECT_GT(expect_parity(*field, options), 0U);
  }
}

}  // namespace
}  // namespace isoextract::gpu

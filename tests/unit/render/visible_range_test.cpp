#include "render/visible_range.hpp"

#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

#include "support/fields.hpp"

namespace isoextract::render {
namespace {

constexpr int kSide = 40;

// Returns a field of float samples; `value` gets the distance from the middle in voxels.
field::ScalarField field_of(const std::function<double(double)>& value) {
  return test::dense_field<float>(glm::ivec3(kSide), [&](int x, int y, int z) {
    const glm::dvec3 from_middle = glm::dvec3(x, y, z) - (kSide - 1) / 2.0;
    return static_cast<float>(value(glm::length(from_middle)));
  });
}

VisibleRange range_of(const field::ScalarField& field) {
  return visible_range(field, field::measure_statistics(field, nullptr, field::WithPercentiles::no));
}

// A bright ball in noise around another value than 0, as in a scan of a tooth.
TEST(VisibleRange, LeavesOutTheNoiseOfTheBackground) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(400, 10);
  const VisibleRange range = range_of(field_of([&](double r) { return noise(random) + (r < 12 ? 500 : 0); }));
  EXPECT_GT(range.low, 400 + 2 * 10);
  EXPECT_LT(range.low, 400 + 5 * 10);
  EXPECT_GT(range.high, 900);
  EXPECT_LT(range.high, 950);
  EXPECT_FALSE(range.both_sides);
}

// Around a ball of values from 0 to 1 there is nothing: all of it stays visible.
TEST(VisibleRange, KeepsFaintValuesOfCleanData) {
  const VisibleRange range = range_of(field_of([](double r) { return std::max(0.0, 1 - r / 15); }));
  EXPECT_LT(range.low, 0.01);
  EXPECT_GT(range.high, 0.8);
}

TEST(VisibleRange, EndsNearTheMeanOfDensitiesOverManyPowersOfTen) {
  std::mt19937 random(3);
  std::normal_distribution<double> exponent(0, 3);
  const VisibleRange range = range_of(field_of([&](double) { return std::exp(exponent(random)); }));
  // The median is 1, the mean 90, the largest of 64,000 samples about 150,000.
  EXPECT_LT(range.low, 30);
  EXPECT_GT(range.high, 100);
  EXPECT_LT(range.high, 10000);
}

TEST(VisibleRange, ShowsBothSidesOfLongTailsAroundZero) {
  std::mt19937 random(5);
  std::exponential_distribution<double> size(1);
  std::bernoulli_distribution sign;
  const auto laplace = [&](double) { return (sign(random) ? 1 : -1) * size(random); };
  const field::ScalarField field = field_of(laplace);
  const VisibleRange range = range_of(field);
  ASSERT_TRUE(range.both_sides);
  EXPECT_NEAR(range.middle, 0, 0.05);
  EXPECT_NEAR(range.low, 2 * std::log(2), 0.05);  // between the quartiles of a Laplace distribution
  EXPECT_NEAR(range.high, std::log(1000), 0.6);
  const auto made = TransferFunction::create(built_in_points(BuiltInTransfer::gray, range, field.kind));
  ASSERT_TRUE(made);
  const auto sigma = [&](double value) { return made->lookup(made->position(value)).a; };
  EXPECT_EQ(sigma(0), 0);
  EXPECT_EQ(sigma(1.2), 0);
  EXPECT_EQ(sigma(-1.2), 0);
  EXPECT_GT(sigma(4), 0.01);
  EXPECT_NEAR(sigma(-4), sigma(4), 0.1 * sigma(4));
  // Uniform values on both sides, such as those of a gyroid, are no such field.
  std::uniform_real_distribution<double> uniform(-1, 1);
  EXPECT_FALSE(range_of(field_of([&](double) { return uniform(random); })).both_sides);
}

TEST(VisibleRange, ShowsLevelSetsInwards) {
  field::ScalarField ball = field_of([](double r) { return r - 10; });
  ball.kind = field::FieldKind::level_set;
  const VisibleRange range = range_of(ball);
  EXPECT_NEAR(range.low, -10, 1);
  EXPECT_EQ(range.high, 0);
  const auto points = built_in_points(BuiltInTransfer::gray, range, ball.kind);
  EXPECT_EQ(points.back().opacity, 0);
  EXPECT_GT(points.front().opacity, 0);
}

TEST(VisibleRange, AcceptsFieldsOfOneValue) {
  const VisibleRange range = range_of(field_of([](double) { return 5; }));
  EXPECT_EQ(range.low, 5);
  EXPECT_GT(range.high, range.low);
}

}  // namespace
}  // namespace isoextract::render

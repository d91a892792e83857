#include "field/demo_field.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "field/analytic_field.hpp"

namespace isoextract::field {
namespace {

float sample(const ScalarField& field, int i, int j, int k) {
  const auto& dense = std::get<DenseSamples>(field.samples);
  return static_cast<const float*>(dense.data)[i + dense.dims.x * (j + dense.dims.y * k)];
}

TEST(DemoField, PlacesSphereWithPositiveInside) {
  const ScalarField field = make_demo_field("demo:sphere?size=21", Context()).value();
  EXPECT_EQ(std::get<DenseSamples>(field.samples).dims, glm::ivec3(21));
  EXPECT_EQ(field.index_to_world({0, 0, 0}), glm::dvec3(-1));
  EXPECT_NEAR(field.index_to_world({20, 10, 20}).x, 1, 1e-15);
  EXPECT_FLOAT_EQ(sample(field, 10, 10, 10), 0.7F);
  EXPECT_NEAR(sample(field, 17, 10, 10), 0, 1e-6);
  EXPECT_LT(sample(field, 0, 0, 0), 0);
}

TEST(DemoField, DoesNotSwapAxes) {
  // The torus lies around the z axis: it is symmetric in x and y, but not in z.
  const ScalarField field = make_demo_field("demo:torus?size=21", Context()).value();
  EXPECT_NEAR(sample(field, 16, 10, 10), 0.25, 1e-6);
  EXPECT_NEAR(sample(field, 10, 16, 10), 0.25, 1e-6);
  EXPECT_LT(sample(field, 10, 10, 16), -0.4);
  const ScalarField gyroid = make_demo_field("demo:gyroid?size=33", Context()).value();
  // sin x cos y + sin y cos z + sin z cos x at x = pi/2 (index 18: 4 pi (18/16 - 1) = pi/2), y = z = 0.
  EXPECT_NEAR(sample(gyroid, 18, 16, 16), 1, 1e-6);
}

TEST(DemoField, MakesEveryDescribedField) {
  for (const DemoDescription& demo : demo_fields()) {
    const auto field = make_demo_field("demo:" + std::string(demo.name) + "?size=9", Context());
    ASSERT_TRUE(field) << demo.name;
    EXPECT_EQ(field->name, demo.name);
  }
}

// Published measurements and mesh hashes use this field.
TEST(DemoField, RandomNeverChanges) {
  const ScalarField field = make_demo_field("demo:random?size=2", Context()).value();
  EXPECT_EQ(sample(field, 0, 0, 0), 0x1.8882ap-1F);
  EXPECT_EQ(sample(field, 1, 0, 0), -0x1.18762p-3F);
  EXPECT_EQ(sample(field, 1, 1, 1), 0x1.16104cp-1F);
}

TEST(DemoField, RefusesUnknownNamesAndKeys) {
  for (const char* spec :
       {"demo:", "demo:cube", "demo:sphere?size=1", "demo:sphere?size=99999", "demo:sphere?size=x",
        "demo:sphere?size=8x", "demo:sphere?time=", "demo:sphere?time=nan", "demo:sphere?time=inf",
        "demo:sphere?time=1x", "demo:torus?time=0", "demo:random?time=0.5", "demo:marschner-lobb?time=0.5",
        "demo:sphere?depth=3", "demo:sphere?size", "demo:sphere?size=8&&"}) {
    const auto field = make_demo_field(spec, Context());
    ASSERT_FALSE(field) << spec;
    EXPECT_EQ(field.error().code, ErrorCode::usage);
  }
}

std::vector<float> samples_of(const std::string& spec) {
  const ScalarField field = make_demo_field(spec, Context()).value();
  const auto& dense = std::get<DenseSamples>(field.samples);
  const auto* values = static_cast<const float*>(dense.data);
  return {values, values + dense.count()};
}

std::vector<std::string> moving_fields() {
  std::vector<std::string> names;
  for (const DemoDescription& demo : demo_fields()) {
    if (!demo.motion.empty()) names.push_back("demo:" + std::string(demo.name) + "?size=17");
  }
  return names;
}

float largest_step(const std::vector<float>& a, const std::vector<float>& b) {
  float largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

TEST(DemoFieldTime, WholePeriodsChangeNoBit) {
  ASSERT_EQ(moving_fields().size(), 3U);
  for (const std::string& name : moving_fields()) {
    const std::vector<float> still = samples_of(name);
    for (const char* time : {"0", "-0", "1", "-3", "1e300", "-1e-300"}) {
      EXPECT_EQ(samples_of(name + "&time=" + time), still) << name << ' ' << time;
    }
    EXPECT_EQ(samples_of(name + "&time=-0.75"), samples_of(name + "&time=0.25")) << name;
    EXPECT_NE(samples_of(name + "&time=0.25"), still) << name;
  }
}

// Small time steps change the samples a little, also across the end of the period.
TEST(DemoFieldTime, MovesWithoutJumps) {
  for (const std::string& name : moving_fields()) {
    std::vector<float> before = samples_of(name);
    float total = 0;
    for (int step = 1; step <= 256; ++step) {
      const std::vector<float> now = samples_of(name + "&time=" + std::to_string(step / 256.0));
      const float moved = largest_step(before, now);
      EXPECT_GT(moved, 0) << name << ' ' << step;
      EXPECT_LT(moved, 1.5F) << name << ' ' << step;  // metaballs have peaks of 12
      total += moved;
      before = now;
    }
    EXPECT_GT(total, 0.9F) << name;
  }
}

TEST(DemoFieldTime, MovesAsHelpSays) {
  // At a quarter of the period the sphere is at the top: 0.25, which is two samples.
  const ScalarField sphere = make_demo_field("demo:sphere?size=17&time=0.25", Context()).value();
  EXPECT_FLOAT_EQ(sample(sphere, 8, 8, 10), 0.7F);
  // A quarter of the gyroid's period along x is 0.125, one sample.
  const ScalarField still = make_demo_field("demo:gyroid?size=17", Context()).value();
  const ScalarField moved = make_demo_field("demo:gyroid?size=17&time=0.25", Context()).value();
  for (int i = 0; i < 16; ++i) EXPECT_NEAR(sample(moved, i + 1, 3, 5), sample(still, i, 3, 5), 1e-5);
  // Each ball keeps its height and its distance from the axis.
  const ScalarField balls = make_demo_field("demo:metaballs?size=17&time=0.5", Context()).value();
  for (int k = 0; k < 17; ++k) EXPECT_LT(sample(balls, 0, 0, k), 0);
}

TEST(DemoFieldTime, HasFormulaOnlyAtTimeZero) {
  EXPECT_NE(find_formula(make_demo_field("demo:sphere?size=8", Context()).value()), nullptr);
  EXPECT_NE(find_formula(make_demo_field("demo:sphere?size=8&time=2", Context()).value()), nullptr);
  EXPECT_EQ(find_formula(make_demo_field("demo:sphere?size=8&time=0.5", Context()).value()), nullptr);
  EXPECT_EQ(find_formula(make_demo_field("demo:random?size=8", Context()).value()), nullptr);
}

TEST(DemoField, ReservesItsSamples) {
  const Context context(MemoryBudget(std::uint64_t{1} << 20U));
  const auto large = make_demo_field("demo:sphere?size=512", context);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(large.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  {
    const auto small = make_demo_field("demo:sphere?size=16", context);
    ASSERT_TRUE(small);
    EXPECT_EQ(context.memory().reserved(), 16U * 16 * 16 * sizeof(float));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST(DemoField, StopsWhenCancelled) {
  const Context context;
  context.cancel();
  const auto field = make_demo_field("demo:sphere?size=16", context);
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace isoextract::field

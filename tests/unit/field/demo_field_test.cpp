#include "field/demo_field.hpp"

#include <gtest/gtest.h>

namespace isoextract::field {
namespace {

float sample(const ScalarField& field, int i, int j, int k) {
  const auto& dense = std::get<DenseSamples>(field.samples);
  return static_cast<const float*>(dense.data)[i + dense.dims.x * (j + dense.dims.y * k)];
}

TEST(DemoField, SphereIsPlacedAndSigned) {
  const ScalarField field = make_demo_field("demo:sphere?size=21").value();
  EXPECT_EQ(std::get<DenseSamples>(field.samples).dims, glm::ivec3(21));
  EXPECT_EQ(field.index_to_world({0, 0, 0}), glm::dvec3(-1));
  EXPECT_NEAR(field.index_to_world({20, 10, 20}).x, 1, 1e-15);
  EXPECT_FLOAT_EQ(sample(field, 10, 10, 10), 0.7F);
  EXPECT_NEAR(sample(field, 17, 10, 10), 0, 1e-6);
  EXPECT_LT(sample(field, 0, 0, 0), 0);
}

TEST(DemoField, AxesAreNotSwapped) {
  // The torus lies around the z axis: x and y alike, z not.
  const ScalarField field = make_demo_field("demo:torus?size=21").value();
  EXPECT_NEAR(sample(field, 16, 10, 10), 0.25, 1e-6);
  EXPECT_NEAR(sample(field, 10, 16, 10), 0.25, 1e-6);
  EXPECT_LT(sample(field, 10, 10, 16), -0.4);
  const ScalarField gyroid = make_demo_field("demo:gyroid?size=33").value();
  // sin x cos y + sin y cos z + sin z cos x at x = pi/2 (index 18: 4 pi (18/16 - 1) = pi/2), y = z = 0.
  EXPECT_NEAR(sample(gyroid, 18, 16, 16), 1, 1e-6);
}

TEST(DemoField, EveryDescriptionCanBeMade) {
  for (const DemoDescription& demo : demo_fields()) {
    const auto field = make_demo_field("demo:" + std::string(demo.name) + "?size=9");
    ASSERT_TRUE(field) << demo.name;
    EXPECT_EQ(field->name, demo.name);
  }
}

// Measurements and the hashes of meshes are of these.
TEST(DemoField, RandomIsWhatItAlwaysWas) {
  const ScalarField field = make_demo_field("demo:random?size=2").value();
  EXPECT_EQ(sample(field, 0, 0, 0), 0x1.8882ap-1F);
  EXPECT_EQ(sample(field, 1, 0, 0), -0x1.18762p-3F);
  EXPECT_EQ(sample(field, 1, 1, 1), 0x1.16104cp-1F);
}

TEST(DemoField, RefusesWhatItDoesNotKnow) {
  for (const char* spec : {"demo:", "demo:cube", "demo:sphere?size=1", "demo:sphere?size=99999", "demo:sphere?size=x",
                           "demo:sphere?size=8x", "demo:sphere?depth=3", "demo:sphere?size", "demo:sphere?size=8&&"}) {
    const auto field = make_demo_field(spec);
    ASSERT_FALSE(field) << spec;
    EXPECT_EQ(field.error().kind, ErrorKind::usage);
  }
}

TEST(DemoField, ReservesItsSamples) {
  const Context context(MemoryBudget(std::uint64_t{1} << 20U));
  const auto large = make_demo_field("demo:sphere?size=512", context);
  ASSERT_FALSE(large);
  EXPECT_EQ(large.error().kind, ErrorKind::input);
  EXPECT_EQ(large.error().hint, Hint(Remedy::raise_memory_limit));
  {
    const auto small = make_demo_field("demo:sphere?size=16", context);
    ASSERT_TRUE(small);
    EXPECT_EQ(context.memory().reserved(), 16U * 16 * 16 * sizeof(float));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST(DemoField, EndsWhereItIsCancelled) {
  const Context context;
  context.cancel();
  const auto field = make_demo_field("demo:sphere?size=16", context);
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace isoextract::field

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

field::ScalarField sphere(int size) {
  return field::make_demo_field("demo:sphere?size=" + std::to_string(size), Context()).value();
}

TEST(Placement, IsTheFullAffineMap) {
  const field::ScalarField field = sphere(20);
  const field::Affine frame{glm::dmat3(1, 0.25, 0, -0.5, 2, 0, 0, 0.125, 0.5), glm::dvec3(3, -4, 5)};
  ExtractOptions options;
  const mesh::Mesh index = test::extract(field, options).mesh;
  options.output_from_index = frame;
  const mesh::Mesh placed = test::extract(field, options).mesh;
  ASSERT_EQ(index.positions.size(), placed.positions.size());
  for (std::size_t v = 0; v < index.positions.size(); ++v) {
    EXPECT_LT(glm::length(placed.position(v) - frame(index.position(v))), 1e-5);
  }
}

TEST(Placement, MirrorsDoNotTurnTheSurfaceInsideOut) {
  for (const Method method : {Method::mc, Method::mt}) {
    for (const bool cap : {false, true}) {
      field::ScalarField field = test::random_field<float>({9, 9, 9}, 3, 1000);
      ExtractOptions options;
      options.method = method;
      options.iso = 700;
      options.cap = true;
      const double volume = mesh::measure_size(test::extract(field, options).mesh).volume;
      options.output_from_index = field::scaling({-1, 1, 1});
      const mesh::Mesh mirrored = test::extract(field, options).mesh;
      test::expect_sound(mirrored, true);
      EXPECT_GT(volume, 0);
      EXPECT_NEAR(mesh::measure_size(mirrored).volume, volume, 1e-3 * volume) << cap;
    }
  }
}

// A sphere of radius 0.7 at 1e7 keeps the accuracy of one at 0.
TEST(Placement, FarAwayKeepsItsAccuracy) {
  const field::ScalarField field = sphere(40);
  const glm::dvec3 far(1e7, -2e7, 3e7);
  ExtractOptions options;
  options.output_from_index = field.index_to_world;
  const mesh::Mesh near_mesh = test::extract(field, options).mesh;
  EXPECT_EQ(near_mesh.origin, glm::dvec3(0));
  options.output_from_index.offset += far;
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  EXPECT_NE(mesh.origin, glm::dvec3(0));
  test::expect_sound(mesh, true);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    // Doubles at 3e7 are 4e-9 apart.
    EXPECT_LT(glm::length(mesh.position(v) - far - near_mesh.position(v)), 2e-7);
  }
}

// Thousands of samples along an axis, ties everywhere: the margin must survive float32.
TEST(Placement, LongRowsWithTiesHaveNoZeroAreaTriangles) {
  const field::ScalarField field = test::dense_field<std::uint8_t>(
      {4000, 6, 6}, [](int i, int j, int k) { return j > 0 && j < 5 && k > 0 && k < 5 ? (i * 7 + j * 3 + k) % 3 : 0; });
  for (const Method method : {Method::mc, Method::mt}) {
    ExtractOptions options;
    options.method = method;
    options.iso = 1;
    test::expect_sound(test::extract(field, options).mesh, false);
    options.iso = 0;
    options.cap = true;
    test::expect_sound(test::extract(field, options).mesh, true);
    // The same rotated, so that rounding has no axis to itself.
    options.output_from_index.linear = glm::dmat3(0.8, 0.6, 0, -0.36, 0.48, 0.8, 0.48, -0.64, 0.6);
    test::expect_sound(test::extract(field, options).mesh, true);
  }
}

// A slab whose one thin axis lies far from 0, though not far for the other two.
TEST(Placement, ThinFarSlabsHaveNoZeroAreaTriangles) {
  ExtractOptions options;
  options.output_from_index = field::scaling({100, 0.0001, 100});
  options.output_from_index.offset.y = 6000;
  const mesh::Mesh mesh = test::extract(sphere(32), options).mesh;
  EXPECT_NE(mesh.origin, glm::dvec3(0));
  test::expect_sound(mesh, true);
}

TEST(Placement, RefusesWhatFloatsCannotHold) {
  for (const double scale : {1e60, 1e-50}) {
    ExtractOptions options;
    options.output_from_index = field::scaling(glm::dvec3(scale));
    const auto result = make_cpu_extractor()->extract(sphere(8), options, Context());
    ASSERT_FALSE(result) << scale;
    EXPECT_EQ(result.error().code, ErrorCode::input);
    EXPECT_EQ(result.error().hint.remedy, Remedy::rescale);
  }
}

TEST(Placement, RefusesMeshesBeyondTheMemoryLimit) {
  const auto result = make_cpu_extractor()->extract(sphere(16), {}, Context(MemoryBudget(1000)));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().hint.remedy, Remedy::raise_memory_limit);
}

TEST(Placement, RefusesFlatTransforms) {
  ExtractOptions options;
  options.output_from_index = field::scaling({1, 0, 1});
  const auto result = make_cpu_extractor()->extract(sphere(8), options, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::input);
}

}  // namespace
}  // namespace isoextract::extract

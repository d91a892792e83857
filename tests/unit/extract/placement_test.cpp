#include <cmath>

#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

field::ScalarField sphere(int size) {
  return field::make_demo_field("demo:sphere?size=" + std::to_string(size), Context()).value();
}

class Placement : public testing::TestWithParam<Method> {
 protected:
  static ExtractOptions options(double iso, bool cap = false) { return test::options_of(GetParam(), iso, cap); }
};
INSTANTIATE_TEST_SUITE_P(Methods, Placement, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(Placement, AppliesFullAffineMap) {
  const field::ScalarField field = sphere(20);
  const field::Affine frame{glm::dmat3(1, 0.25, 0, -0.5, 2, 0, 0, 0.125, 0.5), glm::dvec3(3, -4, 5)};
  ExtractOptions placing = options(0);
  const mesh::Mesh index = test::extract(field, placing).mesh;
  placing.output_from_index = frame;
  const mesh::Mesh placed = test::extract(field, placing).mesh;
  ASSERT_FALSE(index.positions.empty());
  ASSERT_EQ(index.positions.size(), placed.positions.size());
  // Volumes of surface nets are kept for the diagonals of bent faces, which depend on the transform.
  const double tolerance = GetParam() == Method::surface_nets ? 5e-4 : 1e-5;
  for (std::size_t v = 0; v < index.positions.size(); ++v) {
    EXPECT_LT(glm::length(placed.position(v) - frame(index.position(v))), tolerance);
  }
}

TEST_P(Placement, KeepsWindingForMirrorsAndShears) {
  const field::ScalarField field = test::random_field<float>({9, 9, 9}, 3, 1000);
  ExtractOptions placing = options(700, true);
  const double volume = mesh::measure_size(test::extract(field, placing).mesh).volume;
  EXPECT_GT(volume, 0);
  // A bent face of a surface net is split along the diagonal with the better triangles, which depends on the transform.
  const double tolerance = GetParam() == Method::surface_nets ? 5e-3 : 1e-3;
  for (const glm::dmat3& linear : {glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1), glm::dmat3(-0.5, 0, 0, 0.25, 2, 0, 0, -1, 4),
                                   glm::dmat3(0.5, 0, 0, 0.25, 2, 0, 0, -1, 4)}) {
    placing.output_from_index.linear = linear;
    const mesh::Mesh mesh = test::extract(field, placing).mesh;
    test::expect_sound(mesh, true);
    const double expected = volume * std::abs(glm::determinant(linear));
    EXPECT_NEAR(mesh::measure_size(mesh).volume, expected, tolerance * expected);
  }
}

// A sphere of radius 0.7 at 1e7 is as accurate as one at 0.
TEST_P(Placement, KeepsAccuracyFarAway) {
  const field::ScalarField field = sphere(40);
  const glm::dvec3 far(1e7, -2e7, 3e7);
  ExtractOptions placing = options(0);
  placing.output_from_index = field.index_to_world;
  const mesh::Mesh near_mesh = test::extract(field, placing).mesh;
  EXPECT_EQ(near_mesh.origin, glm::dvec3(0));
  placing.output_from_index.offset += far;
  const mesh::Mesh mesh = test::extract(field, placing).mesh;
  EXPECT_NE(mesh.origin, glm::dvec3(0));
  test::expect_sound(mesh, true);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    // Doubles near 3e7 are 4e-9 apart.
    EXPECT_LT(glm::length(mesh.position(v) - far - near_mesh.position(v)), 2e-7);
  }
}

// Thousands of samples along an axis, with ties everywhere: the margin must survive rounding to float32.
TEST_P(Placement, LeavesNoZeroAreaInLongRows) {
  const field::ScalarField field = test::dense_field<std::uint8_t>(
      {4000, 6, 6}, [](int i, int j, int k) { return j > 0 && j < 5 && k > 0 && k < 5 ? (i * 7 + j * 3 + k) % 3 : 0; });
  test::expect_sound(test::extract(field, options(1)).mesh, test::traits_of(GetParam()).always_closed);
  ExtractOptions placing = options(0, true);
  test::expect_sound(test::extract(field, placing).mesh, true);
  // The same rotated, so that rounding acts along all axes.
  placing.output_from_index.linear = glm::dmat3(0.8, 0.6, 0, -0.36, 0.48, 0.8, 0.48, -0.64, 0.6);
  test::expect_sound(test::extract(field, placing).mesh, true);
}

// A slab that is far from 0 along its thin axis, compared with its thickness, but not along the other two.
TEST_P(Placement, LeavesNoZeroAreaInThinFarSlabs) {
  ExtractOptions placing = options(0);
  placing.output_from_index = field::scaling({100, 0.0001, 100});
  placing.output_from_index.offset.y = 6000;
  const mesh::Mesh mesh = test::extract(sphere(32), placing).mesh;
  EXPECT_NE(mesh.origin, glm::dvec3(0));
  test::expect_sound(mesh, true);
}

TEST_P(Placement, RefusesPositionsBeyondFloat32) {
  for (const double scale : {1e60, 1e-50}) {
    ExtractOptions placing = options(0);
    placing.output_from_index = field::scaling(glm::dvec3(scale));
    const auto result = make_cpu_extractor()->extract(sphere(8), placing, Context());
    ASSERT_FALSE(result) << scale;
    EXPECT_EQ(result.error().code, ErrorCode::input);
    EXPECT_EQ(result.error().hint, Hint(Remedy::change, Setting::scale));
  }
}

TEST_P(Placement, RefusesMeshesBeyondTheMemoryLimit) {
  const auto result = make_cpu_extractor()->extract(sphere(16), options(0), Context(MemoryBudget(1000)));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

TEST_P(Placement, RefusesFlatTransforms) {
  ExtractOptions placing = options(0);
  placing.output_from_index = field::scaling({1, 0, 1});
  const auto result = make_cpu_extractor()->extract(sphere(8), placing, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::input);
}

}  // namespace
}  // namespace isoextract::extract

#include <limits>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "support/hints.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Returns a block of ones in zeros, with `value` at its corner sample (3, 4, 5).
field::ScalarField block_with(double value) {
  return test::dense_field<float>({10, 10, 10}, [&](int i, int j, int k) {
    if (i == 3 && j == 4 && k == 5) return value;
    return i >= 3 && i < 7 && j >= 3 && j < 7 && k >= 3 && k < 7 ? 1.0 : 0.0;
  });
}

// Expects a unit normal for each vertex, or no normals at all.
void expect_normals(const mesh::Mesh& mesh, bool wanted) {
  EXPECT_EQ(mesh.normals.size(), wanted ? mesh.positions.size() : 0);
  for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(glm::dvec3(n)), 1, 1e-6);
}

class Nan : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Nan, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(Nan, FailsAndReportsIndex) {
  const ExtractOptions options = test::options_of(GetParam(), 0.5);
  for (const bool sparse : {false, true}) {
    field::ScalarField field = block_with(kNan);
    if (sparse)
      field = test::sparse_copy<float>(
          test::dense_field<float>({16, 16, 16},
                                   [&](int i, int j, int k) { return i == 3 && j == 4 && k == 5 ? kNan : 0.0; }),
          0.0);
    const auto result = make_cpu_extractor()->extract(field, options, Context());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::input);
    EXPECT_NE(result.error().message.find("(3, 4, 5)"), std::string::npos) << result.error().message;
    EXPECT_TRUE(test::has_step(result.error().hint, Remedy::set, Setting::nan_policy));
  }
}

TEST_P(Nan, FailsWithoutInsideSamples) {
  ExtractOptions options = test::options_of(GetParam(), kInfinity);
  EXPECT_FALSE(make_cpu_extractor()->extract(block_with(kNan), options, Context())) << "iso must be finite";
  options.iso = 5;
  EXPECT_FALSE(make_cpu_extractor()->extract(block_with(kNan), options, Context()));
}

TEST_P(Nan, CutsHalfwayAndClosesIfOutside) {
  ExtractOptions options = test::options_of(GetParam(), 0.5);
  options.nan = NanPolicy::outside;
  options.smooth_normals = test::traits_of(GetParam()).gradient_normals;
  const Extraction result = test::extract(block_with(kNan), options);
  EXPECT_EQ(result.stats.nan_samples, 1U);
  test::expect_sound(result.mesh, true);
  expect_normals(result.mesh, options.smooth_normals);
  // The surface also passes halfway between 0 and 1.
  EXPECT_EQ(test::triangle_set(result.mesh), test::triangle_set(test::extract(block_with(0), options).mesh));
  if (test::traits_of(GetParam()).vertices_on_edges) {
    EXPECT_EQ(std::ranges::count(result.mesh.positions, glm::vec3(3.5F, 4, 5)), 1);
  }
}

class Infinity : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, Infinity, testing::ValuesIn(test::all_methods()), test::method_name);

TEST_P(Infinity, MovesSurfaceToFiniteEnd) {
  const MethodTraits& traits = test::traits_of(GetParam());
  ExtractOptions options = test::options_of(GetParam(), 0.5);
  options.smooth_normals = traits.gradient_normals;
  const Extraction result = test::extract(block_with(kInfinity), options);
  test::expect_sound(result.mesh, true);
  expect_normals(result.mesh, options.smooth_normals);
  if (traits.follows_interpolant) {
    EXPECT_NEAR(mesh::measure_bounds(result.mesh).min.x, 2, 1e-3);
  } else {
    EXPECT_EQ(test::triangle_set(result.mesh), test::triangle_set(test::extract(block_with(1), options).mesh));
  }
}

}  // namespace
}  // namespace isoextract::extract

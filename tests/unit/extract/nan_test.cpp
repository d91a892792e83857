#include <limits>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A block of ones in zeros, with `value` at its corner sample (3, 4, 5).
field::ScalarField block_with(double value) {
  return test::dense_field<float>({10, 10, 10}, [&](int i, int j, int k) {
    if (i == 3 && j == 4 && k == 5) return value;
    return i >= 3 && i < 7 && j >= 3 && j < 7 && k >= 3 && k < 7 ? 1.0 : 0.0;
  });
}

TEST(Nan, IsAnErrorThatSaysWhere) {
  ExtractOptions options;
  options.iso = 0.5;
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
    EXPECT_EQ(result.error().hint.remedy, Remedy::choose_nan_policy);
  }
}

TEST(Nan, IsFoundEvenWhereNothingIsInside) {
  ExtractOptions options;
  options.iso = kInfinity;
  EXPECT_FALSE(make_cpu_extractor()->extract(block_with(kNan), options, Context())) << "iso must be finite";
  options.iso = 5;
  EXPECT_FALSE(make_cpu_extractor()->extract(block_with(kNan), options, Context()));
}

TEST(Nan, OutsideCutsHalfwayAndStaysClosed) {
  for (const Method method : {Method::mc, Method::mt}) {
    ExtractOptions options;
    options.method = method;
    options.iso = 0.5;
    options.nan = NanPolicy::outside;
    options.smooth_normals = true;
    const Extraction result = test::extract(block_with(kNan), options);
    EXPECT_EQ(result.stats.nan_samples, 1U);
    test::expect_sound(result.mesh, true);
    bool halfway = false;
    for (std::size_t v = 0; v < result.mesh.positions.size(); ++v) {
      halfway |= result.mesh.positions[v] == glm::vec3(3.5F, 4, 5);
      EXPECT_NEAR(glm::length(glm::dvec3(result.mesh.normals[v])), 1, 1e-6);
    }
    EXPECT_TRUE(halfway);
  }
}

TEST(Infinity, PullsTheSurfaceToTheFiniteEnd) {
  ExtractOptions options;
  options.iso = 0.5;
  options.smooth_normals = true;
  const Extraction result = test::extract(block_with(kInfinity), options);
  test::expect_sound(result.mesh, true);
  for (const glm::vec3& n : result.mesh.normals) EXPECT_NEAR(glm::length(glm::dvec3(n)), 1, 1e-6);
  EXPECT_NEAR(mesh::measure_bounds(result.mesh).min.x, 2, 1e-3);
}

}  // namespace
}  // namespace isoextract::extract

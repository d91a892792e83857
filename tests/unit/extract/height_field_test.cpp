#include "extract/height_field.hpp"

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

double height(int i, int j) { return 3 + 0.25 * i * i - 0.5 * j + 0.125 * i * j; }

field::ScalarField heights() {
  return test::dense_field<double>({7, 5, 1}, [](int i, int j, int) { return height(i, j); });
}

// The formula of the header: the trapezoid rule above the floor, and a twelfth of the twist of the corners.
TEST(HeightField, HasVolumeOfFormula) {
  const double base = -1.5;
  const auto extraction = extract_heights(heights(), {.solid = true, .base = base}, {}, Context());
  ASSERT_TRUE(extraction) << extraction.error().message;
  test::expect_sound(extraction->mesh, true);
  double expected = 0;
  for (int j = 0; j < 4; ++j) {
    for (int i = 0; i < 6; ++i) {
      expected += (height(i, j) + height(i + 1, j) + height(i, j + 1) + height(i + 1, j + 1)) / 4 - base;
    }
  }
  expected += (height(0, 0) - height(6, 0) - height(0, 4) + height(6, 4)) / 12;
  EXPECT_NEAR(mesh::measure_size(extraction->mesh).volume, expected, 1e-5 * expected);
}

TEST(HeightField, RefusesNormalsAndEdgeKeys) {
  for (const bool normals : {true, false}) {
    ExtractOptions options;
    (normals ? options.smooth_normals : options.edge_keys) = true;
    const auto extraction = extract_heights(heights(), {}, options, Context());
    ASSERT_FALSE(extraction);
    EXPECT_EQ(extraction.error().code, ErrorCode::usage);
  }
}

}  // namespace
}  // namespace isoextract::extract

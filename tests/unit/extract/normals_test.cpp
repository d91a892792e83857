#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

class SmoothNormals : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, SmoothNormals, testing::ValuesIn(test::methods_with(&MethodTraits::gradient_normals)),
                         test::method_name);

class NoNormals : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, NoNormals, testing::ValuesIn(test::all_methods()), test::method_name);

// A plane in a sheared, mirrored frame with uneven spacing: its normal is exact everywhere, also at the data boundary.
TEST_P(SmoothNormals, AreExactForPlaneInAnyFrame) {
  const field::Affine frame{glm::dmat3(-2, 0.3, 0, 0.5, 1, 0.2, 0, -0.4, 0.1), glm::dvec3(5, -3, 2)};
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 2, -0.5));
  for (const field::FieldKind kind : {field::FieldKind::density, field::FieldKind::level_set}) {
    for (const double slope : {1.0, -2.0}) {
      // The value is the distance along the normal: it falls inwards for density.
      const double sign = kind == field::FieldKind::density ? -1 : 1;
      field::ScalarField field = test::dense_field<double>({9, 8, 7}, [&](int i, int j, int k) {
        return sign * (glm::dot(normal, frame({i, j, k})) - glm::dot(normal, frame({4, 3.3, 3}))) / slope;
      });
      field.scale = {slope, 0};
      field.kind = kind;
      ExtractOptions options = test::options_of(GetParam(), 0);
      options.smooth_normals = true;
      options.output_from_index = frame;
      const mesh::Mesh mesh = test::extract(field, options).mesh;
      ASSERT_GT(mesh.positions.size(), 20U);
      ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
      for (const glm::vec3& n : mesh.normals) EXPECT_LT(glm::length(glm::dvec3(n) - normal), 1e-6);
      for (const glm::uvec3& t : mesh.triangles) {
        const glm::dvec3 face =
            glm::cross(mesh.position(t.y) - mesh.position(t.x), mesh.position(t.z) - mesh.position(t.x));
        EXPECT_GT(glm::dot(face, normal), 0) << "triangles and normals must agree";
      }
    }
  }
}

TEST_P(NoNormals, AreMadeWithoutOption) {
  const field::ScalarField field = field::make_demo_field("demo:sphere?size=16", Context()).value();
  const mesh::Mesh mesh = test::extract(field, test::options_of(GetParam(), 0)).mesh;
  EXPECT_FALSE(mesh.positions.empty());
  EXPECT_TRUE(mesh.normals.empty());
}

// Zero gradient: a single bright sample between equal neighbors.
TEST_P(SmoothNormals, FallBackToEdgeForZeroGradient) {
  const field::ScalarField field =
      test::dense_field<float>({5, 5, 5}, [](int i, int j, int k) { return (i + j + k) % 2 == 0 ? 1.0F : -1.0F; });
  ExtractOptions options = test::options_of(GetParam(), 0);
  options.smooth_normals = true;
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  for (const glm::vec3& n : mesh.normals) EXPECT_NEAR(glm::length(glm::dvec3(n)), 1, 1e-6);
}

}  // namespace
}  // namespace isoextract::extract

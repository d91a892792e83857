#include <gtest/gtest.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/hints.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

class Region : public testing::TestWithParam<Method> {
 protected:
  static bool always_closed() { return test::traits_of(GetParam()).always_closed; }
};
INSTANTIATE_TEST_SUITE_P(Methods, Region, testing::ValuesIn(test::all_methods()), test::method_name);

// Methods whose surface is open where the region cuts it.
class OpenRegion : public Region {};
INSTANTIATE_TEST_SUITE_P(Methods, OpenRegion, testing::ValuesIn(test::methods_without(&MethodTraits::always_closed)),
                         test::method_name);

// Methods whose surface is closed there.
class ClosedRegion : public Region {};
INSTANTIATE_TEST_SUITE_P(Methods, ClosedRegion, testing::ValuesIn(test::methods_with(&MethodTraits::always_closed)),
                         test::method_name);

// Values that tie with iso move the surface only if it follows the field.
class RegionOfTies : public Region {};
INSTANTIATE_TEST_SUITE_P(Methods, RegionOfTies,
                         testing::ValuesIn(test::methods_with(&MethodTraits::follows_interpolant)), test::method_name);

bool within(const std::array<test::Point, 3>& triangle, const field::IndexBox& box) {
  for (const auto& [x, y, z] : triangle) {
    if (x < box.min.x || x > box.max.x || y < box.min.y || y > box.max.y || z < box.min.z || z > box.max.z)
      return false;
  }
  return true;
}

// The surface of a region consists of the triangles of the whole surface in it, bit for bit.
TEST_P(OpenRegion, EqualsPartOfWhole) {
  const field::ScalarField dense = test::random_field<float>({80, 24, 16}, 11, 1000);
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    ExtractOptions options = test::options_of(GetParam(), 600);
    const auto whole = test::triangle_set(test::extract(*field, options).mesh);
    options.region = field::IndexBox{{3, 5, 2}, {70, 20, 9}};
    std::vector<std::array<test::Point, 3>> expected;
    for (const auto& triangle : whole) {
      if (within(triangle, *options.region)) expected.push_back(triangle);
    }
    const mesh::Mesh part = test::extract(*field, options).mesh;
    EXPECT_EQ(test::triangle_set(part), expected);
    test::expect_sound(part, false);
  }
}

// The surface equals that of a field with only the samples of the region.
TEST_P(ClosedRegion, EqualsSmallerField) {
  const field::IndexBox box{{3, 5, 2}, {70, 20, 9}};
  const field::ScalarField dense = test::random_field<float>({80, 24, 16}, 11, 1000);
  const auto* values = static_cast<const float*>(std::get<field::DenseSamples>(dense.samples).data);
  const field::ScalarField smaller = test::dense_field<float>(glm::ivec3(box.dims()), [&](int i, int j, int k) {
    const glm::ivec3 p = box.min + glm::ivec3(i, j, k);
    return values[p.x + 80 * (p.y + 24 * p.z)];
  });
  ExtractOptions options = test::options_of(GetParam(), 600);
  options.voxel_faces = VoxelFaces::plain;  // merged faces also end at bricks of the whole field
  options.output_from_index.offset = box.min;
  const mesh::Mesh expected = test::extract(smaller, options).mesh;
  test::expect_sound(expected, true);
  options.output_from_index.offset = {};
  options.region = box;
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    EXPECT_EQ(test::triangle_set(test::extract(*field, options).mesh), test::triangle_set(expected));
  }
}

// Samples that tie with iso move the surface by the margin: that of the length of a long field, or that of the region.
TEST_P(RegionOfTies, MovesTiesByOwnMargin) {
  constexpr int kTie = 4000;
  const field::ScalarField field = test::dense_field<std::int16_t>({4200, 4, 4}, [](int i, int, int) { return i; });
  ExtractOptions options = test::options_of(GetParam(), kTie);
  // Distance of the surface from the samples that tie, in steps.
  const auto moved = [&] {
    const mesh::Mesh mesh = test::extract(field, options).mesh;
    double farthest = 0;
    for (const glm::vec3& p : mesh.positions) {
      const double distance = mesh.origin.x + p.x - kTie;
      EXPECT_GT(distance, 0);
      farthest = std::max(farthest, distance);
    }
    return farthest;
  };
  EXPECT_GT(moved(), 0.001);
  options.region = field::IndexBox{{kTie - 10, 0, 0}, {kTie + 10, 3, 3}};
  EXPECT_GT(moved(), 0);
  EXPECT_LT(moved(), 0.00002);
}

TEST_P(Region, ClosesWithCap) {
  const field::ScalarField dense = field::make_demo_field("demo:gyroid?size=32", Context()).value();
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  ExtractOptions options = test::options_of(GetParam(), 0, true);
  options.voxel_faces = VoxelFaces::plain;
  options.region = field::IndexBox{{4, 3, 2}, {21, 28, 13}};
  const mesh::Mesh a = test::extract(dense, options).mesh;
  const mesh::Mesh b = test::extract(sparse, options).mesh;
  test::expect_sound(a, true);
  test::expect_sound(b, true);
  EXPECT_EQ(test::triangle_set(a), test::triangle_set(b));
  const double reach = test::reach_beyond_samples(GetParam());
  EXPECT_EQ(mesh::measure_bounds(a).min, glm::dvec3(4, 3, 2) - reach);
  EXPECT_EQ(mesh::measure_bounds(a).max, glm::dvec3(21, 28, 13) + reach);
}

// A region without a cell is an error, too, except for methods that make samples boxes.
TEST_P(Region, FailsOutsideData) {
  ExtractOptions options = test::options_of(GetParam(), 0);
  for (const field::IndexBox box : {field::IndexBox{{40, 0, 0}, {50, 9, 9}}, field::IndexBox{{0, 0, 0}, {0, 5, 5}}}) {
    options.region = box;
    const auto result =
        make_cpu_extractor()->extract(test::random_field<float>({10, 10, 10}, 1, 9), options, Context());
    if (always_closed() && box.min.x == 0) {
      ASSERT_TRUE(result) << result.error().message;
      EXPECT_FALSE(result->mesh.triangles.empty());
      test::expect_sound(result->mesh, true);
      continue;
    }
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::input);
    EXPECT_TRUE(test::has_step(result.error().hint, Remedy::check, Setting::region));
  }
}

// Two groups of voxels that are farther apart than float32 positions allow: a region around each gives the surface of
// that group alone.
TEST_P(Region, ExtractsFieldTooLargeForFloat32) {
  constexpr int kFar = 1 << 27;
  field::ScalarField field =
      test::sparse_copy<float>(field::make_demo_field("demo:sphere?size=16", Context()).value(), -1);
  ExtractOptions options = test::options_of(GetParam(), 0.1);
  options.smooth_normals = test::traits_of(GetParam()).gradient_normals;
  const auto alone = test::triangle_set(test::extract(field, options).mesh);
  auto& samples = std::get<field::SparseSamples>(field.samples);
  const std::size_t count = samples.blocks.size();
  for (std::size_t b = 0; b < count; ++b) {
    samples.blocks.push_back({samples.blocks[b].origin + kFar, samples.blocks[b].values});
  }

  const auto whole = make_cpu_extractor()->extract(field, options, Context());
  ASSERT_FALSE(whole);
  EXPECT_EQ(whole.error().hint, Hint(Remedy::use, Setting::parts));
  options.region = field::IndexBox{glm::ivec3(-2), glm::ivec3(20)};
  EXPECT_EQ(test::triangle_set(test::extract(field, options).mesh), alone);
  options.region = field::IndexBox{glm::ivec3(kFar - 2), glm::ivec3(kFar + 20)};
  const mesh::Mesh far = test::extract(field, options).mesh;
  test::expect_sound(far, true);
  EXPECT_EQ(far.triangles.size(), alone.size());
  EXPECT_NEAR(glm::length(far.origin - glm::dvec3(kFar)), 0, 40);
}

TEST_P(Region, RefusesOneLayerOfSamples) {
  const auto result = make_cpu_extractor()->extract(test::random_field<float>({10, 1, 10}, 1, 9),
                                                    test::options_of(GetParam(), 0), Context());
  if (always_closed()) {
    ASSERT_TRUE(result) << result.error().message;
    EXPECT_FALSE(result->mesh.triangles.empty());
    test::expect_sound(result->mesh, true);
    return;
  }
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("10 x 1 x 10"), std::string::npos);
}

}  // namespace
}  // namespace isoextract::extract

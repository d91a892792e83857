#include "accuracy/surface_coverage.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "accuracy/field_error.hpp"
#include "field/resample.hpp"
#include "mesh/triangle_tree.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::accuracy {
namespace {

// A large ball, a small one beside it and one far away: all above 0.5.
field::ScalarField three_balls() {
  return test::dense_field<float>({48, 24, 24}, [](int i, int j, int k) {
    const glm::dvec3 p(i, j, k);
    const double large = 8 - glm::length(p - glm::dvec3(11, 12, 12));
    const double small = 1.2 - glm::length(p - glm::dvec3(22, 12, 12));
    const double far = 2.5 - glm::length(p - glm::dvec3(40, 12, 12));
    return 0.5 + std::max({large, small, far});
  });
}

extract::ExtractOptions options_of(const field::ScalarField& field) {
  extract::ExtractOptions options;
  options.iso = 0.5;
  options.output_from_index = field.index_to_world;
  return options;
}

SurfaceCoverage coverage_of(const mesh::Mesh& mesh, const field::ScalarField& field,
                            const field::ScalarField* grid = nullptr,
                            const std::vector<mesh::HalfSpace>& clipped = {}) {
  const auto options = options_of(grid != nullptr ? *grid : field);
  FieldErrorOptions how;
  how.grid = grid;
  how.clipped = clipped;
  return measure_field_error(mesh, field, options, how, Context()).value().coverage.value();
}

TEST(SurfaceCoverage, FindsNothingMissingInSameSurface) {
  field::ScalarField field = three_balls();
  field.index_to_world = {glm::dmat3(2, 0, 0, 0, 0, 3, 0, -1, 0), glm::dvec3(5e4, 0, -3)};
  const SurfaceCoverage coverage = coverage_of(test::extract(field, options_of(field)).mesh, field);
  EXPECT_EQ(coverage.components, 3U);
  EXPECT_EQ(coverage.lost, 0U);
  EXPECT_GT(coverage.distances.points, 500U);
  EXPECT_GT(coverage.distances.rms.voxels, 1e-4);
  EXPECT_LT(coverage.distances.max.voxels, 0.2);
}

// The small ball is missing, which the error from the mesh does not show; the large ball near it must not count
// instead.
TEST(SurfaceCoverage, CountsAndMeasuresMissingComponents) {
  const field::ScalarField field = three_balls();
  const field::ScalarField grid =
      field::resample(field, {17, 9, 9}, field::ResampleKernel::linear, field::NanHandling::left_out, Context())
          .value();
  const mesh::Mesh mesh = test::extract(grid, options_of(grid)).mesh;
  ASSERT_EQ(mesh::measure_topology(mesh).components, 2U);
  const SurfaceCoverage coverage = coverage_of(mesh, field, &grid);
  EXPECT_EQ(coverage.components, 3U);
  EXPECT_EQ(coverage.lost, 1U);
  // From the far side of the small ball to the large one, which ends near x = 19.
  EXPECT_GT(coverage.distances.max.voxels, 2.5);
  EXPECT_LT(coverage.distances.max.voxels, 5.5);
  EXPECT_NEAR(coverage.distances.worst.x, 22.5, 1.5);
  EXPECT_GE(coverage.max_at_most.voxels, coverage.distances.max.voxels);
}

TEST(SurfaceCoverage, ReportsVoxelsAndMeshUnits) {
  field::ScalarField field = three_balls();
  field.index_to_world = field::scaling({10, 10, 10});
  mesh::Mesh mesh = test::extract(field, options_of(field)).mesh;
  for (glm::vec3& p : mesh.positions) p += glm::vec3(0, 0, 100);  // moves everything by ten voxels
  const SurfaceCoverage coverage = coverage_of(mesh, field);
  EXPECT_NEAR(coverage.distances.max.world / coverage.distances.max.voxels, 10, 1e-9);
  EXPECT_GT(coverage.distances.max.voxels, 4);
}

// Between its vertices on grid edges, the surface bulges out of the triangles.
TEST(SurfaceCoverage, MeasuresInsideCells) {
  const field::ScalarField field = test::dense_field<double>(
      {9, 9, 9}, [](int i, int j, int k) { return (i - 4) * (j - 4) * (k - 4) * 0.5 + (i + j + k - 12) * 0.4 + 0.55; });
  const mesh::Mesh mesh = test::extract(field, options_of(field)).mesh;
  const SurfaceCoverage coverage = coverage_of(mesh, field);
  // An independent measurement: points of the trilinear polynomial along z, to the triangles of the mesh.
  const mesh::TriangleTree tree(mesh.positions.span(), mesh.triangles.span());
  const field::Interpolant interpolant(field, field::Interpolation::trilinear);
  field::Interpolant::Cursor at(interpolant);
  double farthest = 0;
  for (int a = 0; a <= 8 * 16; ++a) {
    for (int b = 0; b <= 8 * 16; ++b) {
      const auto value = [&](int cell, double t) { return at({a / 16.0, b / 16.0, cell + t}).value - 0.5; };
      for (int cell = 0; cell < 8; ++cell) {
        const double low = value(cell, 0);
        const double high = value(cell, 0.999999999);
        if ((low > 0) == (high > 0)) continue;
        const glm::dvec3 point(a / 16.0, b / 16.0, cell + low / (low - high));
        farthest = std::max(farthest, std::sqrt(tree.nearest(point - mesh.origin, 0).distance_squared));
      }
    }
  }
  EXPECT_GT(farthest, 0.05);
  EXPECT_GT(coverage.distances.max.voxels, 0.95 * farthest);
  EXPECT_LT(coverage.distances.max.voxels, 1.05 * farthest);
  EXPECT_GE(coverage.max_at_most.voxels, 0.999 * farthest);
}

// The middle of a gap of two voxels is not measured; the bound must still cover it.
TEST(SurfaceCoverage, BoundsDistanceBetweenPoints) {
  const field::ScalarField field = test::dense_field<double>({9, 9, 9}, [](int, int, int k) { return 4.75 - k; });
  const float left = 3.04F;
  const float right = 5.04F;
  const float z = 4.25F;
  const mesh::Mesh mesh = test::make_mesh(
      "gap", {{0, 0, z}, {left, 0, z}, {left, 8, z}, {0, 8, z}, {right, 0, z}, {8, 0, z}, {8, 8, z}, {right, 8, z}},
      {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}});
  const SurfaceCoverage coverage = coverage_of(mesh, field);
  EXPECT_LT(coverage.distances.max.voxels, 0.99);
  EXPECT_GE(coverage.max_at_most.voxels, 1 - 1e-5);
  EXPECT_LT(coverage.max_at_most.voxels, 1.3);
}

TEST(SurfaceCoverage, ReportsAllComponentsMissingWithoutMesh) {
  const field::ScalarField field = three_balls();
  const SurfaceCoverage coverage = coverage_of(mesh::Mesh(), field);
  EXPECT_EQ(coverage.components, 3U);
  EXPECT_EQ(coverage.lost, 3U);
  EXPECT_EQ(coverage.distances.points, 0U);
}

TEST(SurfaceCoverage, IgnoresClippedParts) {
  const field::ScalarField field = three_balls();
  mesh::Mesh mesh = test::extract(field, options_of(field)).mesh;
  // Removes the far ball, as a clip would.
  std::size_t kept = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh.positions[t.x].x < 30) mesh.triangles[kept++] = t;
  }
  Buffer<glm::uvec3> triangles(kept);
  std::copy_n(mesh.triangles.begin(), kept, triangles.begin());
  mesh.triangles = std::move(triangles);
  const SurfaceCoverage cut = coverage_of(mesh, field, nullptr, {{{-1, 0, 0}, -30}});
  EXPECT_EQ(cut.components, 2U);
  EXPECT_EQ(cut.lost, 0U);
  EXPECT_LT(cut.distances.max.voxels, 0.2);
  EXPECT_GT(coverage_of(mesh, field).distances.max.voxels, 10);
}

TEST(SurfaceCoverage, IsIndependentOfThreads) {
  const field::ScalarField field = test::random_field<std::uint8_t>({30, 31, 32}, 4, 256);
  const field::ScalarField grid =
      field::resample(field, {20, 20, 20}, field::ResampleKernel::linear, field::NanHandling::left_out, Context())
          .value();
  extract::ExtractOptions options = options_of(grid);
  options.iso = 127.3;
  const mesh::Mesh mesh = test::extract(grid, options).mesh;
  std::vector<SurfaceCoverage> found;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    FieldErrorOptions how;
    how.grid = &grid;
    found.push_back(measure_field_error(mesh, field, options, how, Context()).value().coverage.value());
  }
  EXPECT_EQ(found[0].lost, found[1].lost);
  EXPECT_GT(found[0].lost, 0U);
  EXPECT_EQ(found[0].distances.rms.world, found[1].distances.rms.world);
  EXPECT_EQ(found[0].distances.max.world, found[1].distances.max.world);
  EXPECT_EQ(found[0].distances.worst, found[1].distances.worst);
  EXPECT_EQ(found[0].max_at_most.world, found[1].max_at_most.world);
}

TEST(SurfaceCoverage, ReservesMemory) {
  const field::ScalarField field = three_balls();
  const mesh::Mesh mesh = test::extract(field, options_of(field)).mesh;
  EXPECT_FALSE(measure_field_error(mesh, field, options_of(field), {}, Context(MemoryBudget(20000))));
}

// The mesh ends at x = 3, the cut is at 3.06: the triangles between have their centers outside.
TEST(SurfaceCoverage, BoundsPartsOfTrianglesInsideClip) {
  const field::ScalarField field = test::dense_field<double>({9, 9, 9}, [](int, int, int k) { return 4.75 - k; });
  const float z = 4.25F;
  const mesh::Mesh mesh = test::make_mesh("half", {{-6, 4, z}, {3, -12, z}, {3, 20, z}}, {{0, 1, 2}});
  const SurfaceCoverage coverage = coverage_of(mesh, field, nullptr, {{{-1, 0, 0}, -3.06}});
  EXPECT_LT(coverage.distances.max.voxels, 1e-4);
  EXPECT_NEAR(coverage.max_at_most.voxels, 0.06, 1e-4);
}

}  // namespace
}  // namespace isoextract::accuracy

#include "accuracy/field_error.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::accuracy {
namespace {

struct OfField {
  extract::ExtractOptions options;
  mesh::Mesh mesh;
};

OfField extract_at(const field::ScalarField& field, double iso, extract::Method method = extract::Method::mc) {
  OfField result;
  result.options.iso = iso;
  result.options.method = method;
  result.options.output_from_index = field.index_to_world;
  result.mesh = test::extract(field, result.options).mesh;
  return result;
}

FieldError error_of(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& options,
                    const FieldErrorOptions& how) {
  return measure_field_error(mesh, field, options, how, Context()).value();
}

// A plane in a sheared, mirrored, anisotropic frame: a mesh moved along the plane's normal has exactly that error. Only
// the inverse transpose gives this distance.
TEST(FieldError, MeasuresDistanceOfMovedPlane) {
  const field::Affine frame{glm::dmat3(-2, 0.3, 0, 0.5, 1, 0.2, 0, -0.4, 0.1), glm::dvec3(5, -3, 2)};
  const glm::dvec3 normal = glm::normalize(glm::dvec3(1, 2, -0.5));
  field::ScalarField field = test::dense_field<double>({9, 8, 7}, [&](int i, int j, int k) {
    return 3 * glm::dot(normal, frame({i, j, k}) - frame({4, 3.3, 3}));
  });
  field.index_to_world = frame;
  for (const field::Interpolation interpolation : {field::Interpolation::trilinear, field::Interpolation::tricubic}) {
    OfField plane = extract_at(field, 0);
    const FieldError exact = error_of(plane.mesh, field, plane.options, {interpolation});
    EXPECT_EQ(exact.interior.points, 7 * plane.mesh.triangles.size());
    EXPECT_EQ(exact.vertices.points, plane.mesh.positions.size());
    EXPECT_LT(exact.interior.max.world, 2e-6);
    plane.mesh.origin += 0.01 * normal;
    const FieldError moved = error_of(plane.mesh, field, plane.options, {interpolation});
    EXPECT_NEAR(moved.interior.rms.world, 0.01, 2e-6);
    EXPECT_NEAR(moved.interior.max.world, 0.01, 2e-6);
    EXPECT_NEAR(moved.interior.percentile99.world, 0.01, 2e-6);
    EXPECT_NEAR(moved.vertices.rms.world, 0.01, 2e-6);
    EXPECT_NEAR(moved.interior.rms.voxels, glm::length(glm::inverse(frame.linear) * (0.01 * normal)), 2e-5);
    EXPECT_EQ(moved.interior.unmeasured() + moved.interior.corrected, 0U);
  }
}

// A sample at a corner of the data equals iso up to rounding, with the sign of its neighbors. Marching tetrahedra put a
// vertex there, but the surface lies outside the data. Inside the data it crosses the cell's diagonal at a root found
// by bisection.
TEST(FieldError, IgnoresSurfaceOutsideData) {
  const double beside = 0.75574958324432373;
  const double across = 0.26083886623382568;
  const std::array<double, 4> of_corners{1.4695761172230830e-15, beside, across, -1.4847321510314941};
  const auto value = [&](int i, int j, int k) { return of_corners.at(static_cast<std::size_t>(i + j + k)); };
  const OfField cell = extract_at(test::dense_field<double>({2, 2, 2}, value), 0, extract::Method::mt);
  double low = 0.3;
  double high = 1;
  const auto on_diagonal = [&](double t) {
    const double u = 1 - t;
    return of_corners[0] * u * u * u + 3 * beside * t * u * u + 3 * across * t * t * u + of_corners[3] * t * t * t;
  };
  for (int i = 0; i < 50; ++i) (on_diagonal((low + high) / 2) > 0 ? low : high) = (low + high) / 2;
  const FieldError error = error_of(cell.mesh, test::dense_field<double>({2, 2, 2}, value), cell.options, {});
  EXPECT_NEAR(error.interior.max.voxels, std::sqrt(3.0) * low, 0.005);
}

// Values with a large offset that keeps their digits, and values whose squares would underflow.
TEST(FieldError, KeepsPrecisionForLargeAndSmallValues) {
  constexpr double kOffset = 1e15;
  const auto ball = [](int i, int j, int k) {
    return (8 - glm::distance(glm::dvec3(i, j, k), glm::dvec3(11.3, 11.7, 11.1)) + kOffset) - kOffset;
  };
  const auto error_at = [&](double factor, double offset) {
    const field::ScalarField field =
        test::dense_field<double>({24, 24, 24}, [&](int i, int j, int k) { return factor * ball(i, j, k) + offset; });
    const OfField made = extract_at(field, offset);
    return error_of(made.mesh, field, made.options, {});
  };
  const FieldError plain = error_at(1, 0);
  for (const FieldError& other : {error_at(1, kOffset), error_at(0x1p-1030, 0), error_at(0x1p1000, 0)}) {
    EXPECT_NEAR(other.interior.rms.voxels, plain.interior.rms.voxels, 1e-3 * plain.interior.rms.voxels);
    EXPECT_NEAR(other.interior.max.voxels, plain.interior.max.voxels, 1e-2 * plain.interior.max.voxels);
    EXPECT_NEAR(other.coverage->distances.rms.voxels, plain.coverage->distances.rms.voxels,
                1e-2 * plain.coverage->distances.rms.voxels);
  }
}

// The largest distance between a trilinear sphere and its triangles has the expected size and place.
TEST(FieldError, MeasuresSagittaOfSphere) {
  const field::ScalarField field = field::make_demo_field("demo:sphere?size=65", Context()).value();
  const OfField sphere = extract_at(field, 0);
  const FieldError error = error_of(sphere.mesh, field, sphere.options, {field::Interpolation::tricubic});
  const double voxel = 2.0 / 64;
  EXPECT_NEAR(error.interior.rms.world, error.interior.rms.voxels * voxel, 1e-12);
  EXPECT_LT(error.interior.max.world, 2 * voxel * voxel / (8 * 0.7) * 1.5)
      << "a face diagonal's sagitta, and some more";
  EXPECT_GT(error.interior.max.world, voxel * voxel / (8 * 0.7) / 2);
  EXPECT_NEAR(glm::length(error.interior.worst), 0.7, voxel);
  EXPECT_LE(error.interior.rms.world, error.interior.percentile99.world);
  EXPECT_LE(error.interior.percentile99.world, error.interior.max.world);
}

TEST(FieldError, MeasuresStorageErrorOfVertices) {
  for (const double offset : {0.0, 1e7}) {
    field::ScalarField field = field::make_demo_field("demo:torus?size=40", Context()).value();
    field.index_to_world.offset += offset;
    for (const extract::Method method : {extract::Method::mc, extract::Method::mt}) {
      const OfField torus = extract_at(field, 0, method);
      const FieldError error = error_of(torus.mesh, field, torus.options, {});
      EXPECT_LT(error.storage.max.voxels, 40 * 0x1p-20) << "float32 and the margin";
      EXPECT_GT(error.storage.max.voxels, 0);
      if (method == extract::Method::mc) {
        EXPECT_EQ(error.storage.points, error.vertices.points);
        EXPECT_EQ(error.storage.max.voxels, error.vertices.max.voxels);
      } else {
        EXPECT_GT(error.storage.points, error.vertices.points / 5);
        EXPECT_LT(error.storage.points, error.vertices.points);
        EXPECT_GT(error.vertices.max.voxels, 1e-3) << "on diagonals the interpolant is not linear";
      }
      EXPECT_GT(error.interior.rms.voxels, 1e-3);
    }
  }
}

// In a nearly flat field, |f - iso| / |grad f| alone would give 500 voxels; the surface is 0.75 voxels away.
TEST(FieldError, CorrectsAndCountsFirstOrderEstimates) {
  const field::ScalarField field = test::dense_field<double>({3, 3, 3}, [](int i, int, int) {
    return i == 0 ? 0 : i == 1 ? 0.001 : 1;
  });
  extract::ExtractOptions options;
  options.iso = 0.50050;
  const mesh::Mesh mesh =
      test::make_mesh("t", {{0.75F, 0.5F, 0.5F}, {0.75F, 1.5F, 0.5F}, {0.75F, 0.5F, 1.5F}}, {{0, 1, 2}});
  const FieldError error = error_of(mesh, field, options, {});
  EXPECT_EQ(error.interior.points, 7U);
  EXPECT_EQ(error.interior.corrected, 7U);
  EXPECT_NEAR(error.interior.max.voxels, 0.75, 1e-6);
}

// The surface only touches one sample with exactly the iso value between higher ones. No gradient leads there, but the
// vertices around it are only the margin away.
TEST(FieldError, FindsSurfaceTouchingOneSample) {
  const field::ScalarField field = test::dense_field<std::uint8_t>({5, 5, 5}, [](int i, int j, int k) {
    return glm::ivec3(i, j, k) == glm::ivec3(2) ? 60 : 70 + i + 3 * j + 7 * k;
  });
  const OfField touching = extract_at(field, 60);
  ASSERT_EQ(touching.mesh.triangles.size(), 8U);
  const FieldError error = error_of(touching.mesh, field, touching.options, {});
  EXPECT_EQ(error.vertices.unmeasured() + error.interior.unmeasured(), 0U);
  EXPECT_LT(error.vertices.max.voxels, 1e-5);
  EXPECT_LT(error.interior.max.voxels, 1e-5);
}

// Outside the data, the polynomial of the outermost cell crosses iso; that is no surface.
TEST(FieldError, FindsNoSurfaceBeyondDataBoundary) {
  const mesh::Mesh near_boundary =
      test::make_mesh("t", {{0.1F, 1, 1}, {0.1F, 1.5F, 1}, {0.1F, 1, 1.5F}, {3.9F, 1, 1}}, {{0, 1, 2}});
  extract::ExtractOptions options;
  const field::ScalarField beyond = test::dense_field<float>({5, 5, 5}, [](int i, int, int) { return i + 0.25; });
  const field::ScalarField before = test::dense_field<float>({5, 5, 5}, [](int i, int, int) { return i - 4.25; });
  for (const field::Interpolation interpolation : {field::Interpolation::trilinear, field::Interpolation::tricubic}) {
    const FieldError low = error_of(near_boundary, beyond, options, {interpolation});
    EXPECT_EQ(low.interior.points + low.vertices.points, 0U);
    EXPECT_EQ(low.interior.unreached, 7U);
    EXPECT_EQ(low.vertices.unreached, 4U);
    EXPECT_EQ(error_of(near_boundary, before, options, {interpolation}).vertices.unreached, 4U);
  }

  // The plane x + z / 2 = 1 meets the data boundary x = 0 at z = 2. The feet of these points lie outside, so that line
  // is nearest.
  const field::ScalarField plane =
      test::dense_field<double>({5, 5, 5}, [](int i, int, int k) { return i + k / 2.0 - 1; });
  const mesh::Mesh mesh =
      test::make_mesh("t", {{0.05F, 1, 2.3F}, {0.05F, 1.5F, 2.3F}, {0.05F, 1.2F, 2.3F}}, {{0, 1, 2}});
  const FieldError error = error_of(mesh, plane, options, {});
  EXPECT_EQ(error.vertices.points, 3U);
  EXPECT_NEAR(error.vertices.max.voxels, std::hypot(0.05, 0.3), 1e-5);
  EXPECT_NEAR(error.vertices.rms.voxels, error.vertices.max.voxels, 1e-5);
}

TEST(FieldError, CountsUnmeasurablePoints) {
  const mesh::Mesh mesh =
      test::make_mesh("t", {{0.5F, 0.25F, 0.25F}, {0.5F, 0.75F, 0.25F}, {0.5F, 0.25F, 0.75F}}, {{0, 1, 2}});
  extract::ExtractOptions options;
  options.iso = 0.5;
  const field::ScalarField flat = test::dense_field<float>({3, 3, 3}, [](int, int, int) { return 0; });
  const FieldError on_flat = error_of(mesh, flat, options, {});
  EXPECT_EQ(on_flat.interior.unreached, 7U) << "there is no isosurface";
  EXPECT_EQ(on_flat.interior.points, 0U);
  const field::ScalarField bad = test::dense_field<float>(
      {3, 3, 3}, [](int i, int, int) { return i == 0 ? std::numeric_limits<float>::quiet_NaN() : 1; });
  options.nan = extract::NanPolicy::outside;
  const FieldError beside_nan = error_of(mesh, bad, options, {});
  EXPECT_EQ(beside_nan.interior.not_finite, 7U);
  EXPECT_EQ(beside_nan.vertices.not_finite, 3U);
  EXPECT_EQ(beside_nan.interior.unmeasured(), 7U);
}

// Along the gradient, these points are 0.35 voxels from a saddle's surface; its nearest point is in the next cell.
TEST(FieldError, MeasuresToNearestPoint) {
  const field::ScalarField field =
      test::dense_field<double>({9, 9, 9}, [](int i, int j, int) { return (i - 4) * (j - 4) - 0.25; });
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::make_mesh("t", {{4.05F, 4.1F, 2}, {4.05F, 4.1F, 3}, {4.1F, 4.05F, 2.5F}}, {{0, 1, 2}});
  const FieldError error = error_of(mesh, field, options, {});
  // The distance from (0.05, 0.1) to the hyperbola x y = 1/4, by a fine search.
  double nearest = 1;
  for (int k = 1; k < 100000; ++k) {
    const double x = k * 2e-5;
    if (0.25 / x <= 1 && x <= 1) nearest = std::min(nearest, std::hypot(x - 0.05, 0.25 / x - 0.1));
  }
  EXPECT_NEAR(error.vertices.max.voxels, nearest, 1e-4);
}

// Far points count: a mesh nine voxels from the isosurface has an error of nine voxels.
TEST(FieldError, MeasuresFarPoints) {
  const field::ScalarField field = test::dense_field<float>(
      {40, 40, 40}, [](int i, int j, int k) { return 8 - std::hypot(i - 20, j - 20, k - 20); });
  OfField ball = extract_at(field, 0);
  for (glm::vec3& p : ball.mesh.positions) p = glm::vec3(20) + (p - glm::vec3(20)) * (17.0F / 8);
  const FieldError error = error_of(ball.mesh, field, ball.options, {});
  EXPECT_EQ(error.interior.unmeasured() + error.vertices.unmeasured(), 0U);
  EXPECT_NEAR(error.vertices.rms.voxels, 9, 0.1);
  EXPECT_NEAR(error.vertices.max.voxels, 9, 0.2);
}

// The voxels method puts vertices off the surface, too, at corners of voxels.
TEST(FieldError, SearchesUpToOutermostSamplesForClosedMethods) {
  const field::ScalarField plane = test::dense_field<float>({9, 9, 9}, [](int, int, int k) { return 4.25 - k; });
  OfField boxes = extract_at(plane, 0, extract::Method::voxels);
  const FieldError error = error_of(boxes.mesh, plane, boxes.options, {});
  EXPECT_NEAR(error.interior.rms.voxels, 0.25, 1e-6);
  EXPECT_NEAR(error.interior.max.voxels, 0.25, 1e-6);
  EXPECT_GT(error.cap_triangles, 0U);
  ASSERT_TRUE(error.coverage);
  EXPECT_NEAR(error.coverage->distances.rms.voxels, 0.25, 1e-6);
}

// Seven points are too few for a triangle of 20 voxels, so it is measured in parts.
TEST(FieldError, DividesLargeTriangles) {
  const field::ScalarField field =
      test::dense_field<double>({24, 24, 24}, [](int i, int, int k) { return k - 12 - (i == 13 ? 2 : 0); });
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::make_mesh("t", {{1, 1, 12}, {22, 1, 12}, {1, 22, 12}}, {{0, 1, 2}});
  const FieldError error = error_of(mesh, field, options, {});
  EXPECT_GT(error.interior.points, 1000U);
  EXPECT_NEAR(error.interior.max.voxels, 2 / std::sqrt(5.0), 0.1) << "to the flank of the ridge";
}

TEST(FieldError, SkipsCaps) {
  const field::ScalarField field = field::make_demo_field("demo:gyroid?size=40", Context()).value();
  const OfField open = extract_at(field, 0.1);
  extract::ExtractOptions capped = open.options;
  capped.cap = true;
  const mesh::Mesh closed = test::extract(field, capped).mesh;
  const FieldError error = error_of(closed, field, capped, {});
  const FieldError without_caps = error_of(open.mesh, field, open.options, {});
  EXPECT_EQ(error.cap_triangles, closed.triangles.size() - open.mesh.triangles.size());
  EXPECT_EQ(error.interior.points, without_caps.interior.points);
  EXPECT_EQ(error.interior.max.world, without_caps.interior.max.world);
  EXPECT_EQ(error.vertices.points, without_caps.vertices.points);
}

TEST(FieldError, IsIndependentOfThreadsAndLayout) {
  const field::ScalarField dense = test::dense_field<float>(
      {64, 64, 64}, [](int i, int j, int k) { return std::max(-0.2, 20 - std::hypot(i - 31.3, j - 32.1, k - 30.7)); });
  const field::ScalarField sparse = test::sparse_copy<float>(dense, static_cast<double>(-0.2F));
  const OfField of_dense = extract_at(dense, 0);
  const OfField of_sparse = extract_at(sparse, 0);
  for (const field::Interpolation interpolation : {field::Interpolation::trilinear, field::Interpolation::tricubic}) {
    const FieldError error = error_of(of_dense.mesh, dense, of_dense.options, {interpolation});
    const FieldError same = error_of(of_sparse.mesh, sparse, of_sparse.options, {interpolation});
    EXPECT_NEAR(error.interior.rms.world, same.interior.rms.world, 1e-9);
    EXPECT_NEAR(error.interior.max.world, same.interior.max.world, 1e-6);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const FieldError alone = error_of(of_dense.mesh, dense, of_dense.options, {interpolation});
    EXPECT_EQ(error.interior.rms.world, alone.interior.rms.world);
    EXPECT_EQ(error.interior.percentile99.voxels, alone.interior.percentile99.voxels);
    EXPECT_EQ(error.interior.worst, alone.interior.worst);
  }
}

std::uint64_t most_reserved(const field::ScalarField& field) {
  const OfField of = extract_at(field, 0.5);
  const Context context;
  EXPECT_TRUE(measure_field_error(of.mesh, field, of.options, {}, context));
  return context.memory().peak();
}

// Two interpolants hold tables of the same sparse blocks.
TEST(FieldError, ReservesMemoryForSparseBlocks) {
  constexpr int kBlocks = 32;
  const auto nodes = [](std::uint64_t count) { return count * sizeof(field::SparseLookup::Node); };
  const std::uint64_t together = most_reserved(test::row_of_blocks(kBlocks, 8));  // in 2 nodes
  EXPECT_GT(most_reserved(test::row_of_blocks(kBlocks, 128)), together + nodes(kBlocks - 2) * 3 / 2);
}

}  // namespace
}  // namespace isoextract::accuracy

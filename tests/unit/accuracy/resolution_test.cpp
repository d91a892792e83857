// Meshes from a grid with another resolution than the data, measured against the data.
#include <cmath>

#include <gtest/gtest.h>

#include "accuracy/analytic_error.hpp"
#include "accuracy/field_error.hpp"
#include "field/demo_field.hpp"
#include "field/resample.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::accuracy {
namespace {

struct Case {
  field::ScalarField data;
  double iso;
};

struct Measured {
  field::ScalarField grid;
  extract::ExtractOptions options;
  mesh::Mesh mesh;
  FieldError error;
};

Measured measure(const field::ScalarField& data, double iso, const glm::ivec3& resolution,
                 extract::Method method = extract::Method::mc, bool cap = false) {
  Measured result;
  result.grid =
      field::resample(data, resolution, field::ResampleKernel::linear, field::NanHandling::left_out, Context()).value();
  result.options.iso = iso;
  result.options.method = method;
  result.options.cap = cap;
  result.options.output_from_index = result.grid.index_to_world;
  result.mesh = test::extract(result.grid, result.options).mesh;
  FieldErrorOptions options;
  options.grid = &result.grid;
  result.error = measure_field_error(result.mesh, data, result.options, options, Context()).value();
  return result;
}

// The interpolant of coarse data has a curved surface inside its cells. Finer grids approach it with the square of
// their step. The frame is rotated, anisotropic and mirrored.
TEST(Resolution, ConvergesToInterpolant) {
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  field::ScalarField sphere = field::make_demo_field("demo:sphere?size=9", Context()).value();
  sphere.index_to_world = {glm::dmat3(-2 * c, -2 * s, 0, -0.5 * s, 0.5 * c, 0.1, 0, 0, 1), glm::dvec3(100, -30, 7)};
  const field::ScalarField random = test::random_field<std::uint8_t>({6, 5, 7}, 4, 256);
  for (const Case& data : {Case{sphere, 0}, Case{random, 127.3}}) {
    const glm::ivec3 cells = std::get<field::DenseSamples>(data.data.samples).dims - 1;
    for (const extract::Method method : {extract::Method::mc, extract::Method::mt}) {
      const double coarse = measure(data.data, data.iso, 4 * cells + 1, method).error.interior.rms.voxels;
      const double fine = measure(data.data, data.iso, 16 * cells + 1, method).error.interior.rms.voxels;
      EXPECT_GT(std::log2(coarse / fine) / 2, 1.8) << coarse << " " << fine;
      EXPECT_LT(std::log2(coarse / fine) / 2, 2.3) << coarse << " " << fine;
    }
  }
}

TEST(Resolution, MeasuresInVoxelsOfData) {
  const field::ScalarField data = field::make_demo_field("demo:torus?size=33", Context()).value();
  const Measured finer = measure(data, 0, {60, 71, 40});
  EXPECT_EQ(finer.error.storage.points, 0U);
  EXPECT_EQ(finer.error.interior.unmeasured(), 0U);
  EXPECT_NEAR(finer.error.interior.rms.world / finer.error.interior.rms.voxels, 2.0 / 32, 1e-9);
  // The grid's voxels are anisotropic, the data's are not, so the formula can be compared.
  const auto truth =
      measure_analytic_error(finer.mesh, data, finer.options, &finer.grid, {}, Context()).value().value();
  EXPECT_LT(truth.interior.max.voxels, 0.2);
  EXPECT_NEAR(truth.interior.rms.world / truth.interior.rms.voxels, 2.0 / 32, 1e-9);
  EXPECT_GT(truth.volume.value(), 0);
}

// Vertices are exact on edges inside one cell of the data.
TEST(Resolution, PlacesVerticesExactlyOnFractionalGrids) {
  field::ScalarField data = field::make_demo_field("demo:gyroid?size=17", Context()).value();
  data.index_to_world.offset += 1000.0;
  const Measured finer = measure(data, 0.1, {65, 65, 65});
  EXPECT_GT(finer.error.vertices.points, 0U);
  EXPECT_LT(finer.error.vertices.max.voxels, 1e-3) << "float32 at 1000 units";
}

// Caps lie on the boundary of the grid: with a region between samples of the data, and around sparse data with an
// inside background, which have no boundary of their own.
TEST(Resolution, RecognizesCaps) {
  const field::ScalarField data = field::make_demo_field("demo:gyroid?size=20", Context()).value();
  const Measured closed = measure(data, 0.1, {30, 44, 27}, extract::Method::mc, true);
  const Measured open = measure(data, 0.1, {30, 44, 27});
  EXPECT_EQ(closed.error.cap_triangles, closed.mesh.triangles.size() - open.mesh.triangles.size());
  EXPECT_EQ(closed.error.interior.points, open.error.interior.points);

  extract::ExtractOptions part = closed.options;
  part.region = field::IndexBox{glm::ivec3(3, 4, 5), glm::ivec3(21, 33, 16)};
  extract::ExtractOptions open_part = part;
  open_part.cap = false;
  const mesh::Mesh mesh = test::extract(closed.grid, part).mesh;
  FieldErrorOptions options;
  options.grid = &closed.grid;
  EXPECT_EQ(measure_field_error(mesh, data, part, options, Context()).value().cap_triangles,
            mesh.triangles.size() - test::extract(closed.grid, open_part).mesh.triangles.size());

  field::ScalarField hollow = test::sparse_copy<float>(
      test::dense_field<float>({16, 16, 16}, [](int i, int j, int k) { return i == 7 && j == 8 && k == 8 ? -1 : 1; }),
      1);
  std::get<field::SparseSamples>(hollow.samples).active_box = {glm::ivec3(5), glm::ivec3(10)};
  const Measured cavity = measure(hollow, 0.2, {13, 14, 15}, extract::Method::mc, true);
  EXPECT_EQ(cavity.error.interior.unmeasured(), 0U);
  EXPECT_LT(cavity.error.interior.max.voxels, 0.5);
  EXPECT_GT(cavity.error.cap_triangles, cavity.mesh.triangles.size() / 2);
}

}  // namespace
}  // namespace isoextract::accuracy

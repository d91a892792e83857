// The error of a mesh does not depend on the windows in which it is measured.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "accuracy/detail/quadrature.hpp"
#include "accuracy/detail/search_window.hpp"
#include "accuracy/field_error.hpp"
#include "field/resample.hpp"
#include "mesh/components.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::accuracy {
namespace {

constexpr std::uint64_t kOneWindow = std::numeric_limits<std::uint32_t>::max();

void expect_same(const ErrorStatistics& a, const ErrorStatistics& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.unmeasured(), b.unmeasured());
  EXPECT_EQ(a.corrected, b.corrected);
  EXPECT_NEAR(a.rms.voxels, b.rms.voxels, 1e-10 * a.rms.voxels);
  EXPECT_NEAR(a.rms.world, b.rms.world, 1e-10 * a.rms.world);
  EXPECT_NEAR(a.percentile99.voxels, b.percentile99.voxels, a.percentile99.voxels / 60);
  EXPECT_NEAR(a.max.voxels, b.max.voxels, 1e-9 * a.max.voxels);
  EXPECT_NEAR(a.max.world, b.max.world, 1e-9 * a.max.world);
}

// Among equally near triangles, windows may choose another one, which changes the bound between the points.
void expect_same(const FieldError& a, const FieldError& b, double bound_tolerance = 0.02) {
  expect_same(a.interior, b.interior);
  expect_same(a.vertices, b.vertices);
  expect_same(a.storage, b.storage);
  EXPECT_EQ(a.cap_triangles, b.cap_triangles);
  ASSERT_EQ(a.coverage.has_value(), b.coverage.has_value());
  if (!a.coverage) return;
  expect_same(a.coverage->distances, b.coverage->distances);
  EXPECT_NEAR(a.coverage->max_at_most.voxels, b.coverage->max_at_most.voxels,
              bound_tolerance * a.coverage->max_at_most.voxels);
  EXPECT_EQ(a.coverage->components, b.coverage->components);
  EXPECT_EQ(a.coverage->lost, b.coverage->lost);
}

// A tube that winds through the data, with balls of several sizes beside it.
float tube_and_balls(const glm::dvec3& p) {
  const double tube =
      5 - glm::length(glm::dvec2(p) - glm::dvec2(30 + 14 * std::sin(p.z / 9), 32 + 12 * std::cos(p.z / 7)));
  double value = tube;
  for (int b = 0; b < 9; ++b) {
    const glm::dvec3 center(7 + 6 * b % 50, 8 + (23 * b) % 47, 6 + 9 * b);
    value = std::max(value, 1.6 + 0.2 * b - glm::length(p - center));
  }
  return static_cast<float>(value);
}

field::ScalarField tube_field() {
  field::ScalarField field =
      test::dense_field<float>({64, 64, 89}, [](int i, int j, int k) { return tube_and_balls(glm::dvec3(i, j, k)); });
  field.index_to_world = {glm::dmat3(1.5, 0.1, 0, 0, 2, 0.3, -0.2, 0, 1), glm::dvec3(5, -20, 7)};
  return field;
}

extract::ExtractOptions options_of(const field::ScalarField& field, extract::Method method = extract::Method::mc) {
  extract::ExtractOptions options;
  options.method = method;
  options.output_from_index = field.index_to_world;
  return options;
}

FieldErrorOptions in_windows(std::uint64_t triangles) {
  FieldErrorOptions options;
  options.window_triangles = triangles;
  return options;
}

TEST(ErrorWindows, GiveTheSameFigures) {
  const field::ScalarField field = tube_field();
  using field::Interpolation;
  for (const auto& [method, interpolation] : {std::pair(extract::Method::mc, Interpolation::trilinear),
                                              std::pair(extract::Method::mc, Interpolation::tricubic),
                                              std::pair(extract::Method::mt, Interpolation::trilinear)}) {
    const extract::ExtractOptions options = options_of(field, method);
    const mesh::Mesh mesh = test::extract(field, options).mesh;
    FieldErrorOptions how = in_windows(kOneWindow);
    how.interpolation = interpolation;
    const FieldError whole = measure_field_error(mesh, field, options, how, Context()).value();
    EXPECT_GT(whole.coverage->components, 5U);
    expect_same(whole, measure_extraction_error(field, options, how, Context()).value());
    how.window_triangles = method == extract::Method::mt ? 300 : 1500;
    expect_same(whole, measure_field_error(mesh, field, options, how, Context()).value());
    expect_same(whole, measure_extraction_error(field, options, how, Context()).value());
  }
}

TEST(ErrorWindows, GiveTheSameFiguresOfSparseSamples) {
  const field::ScalarField dense = test::dense_field<float>(
      {64, 64, 88}, [](int i, int j, int k) { return std::max(-3.0F, tube_and_balls(glm::dvec3(i, j, k))); });
  const field::ScalarField field = test::sparse_copy<float>(dense, -3.0);
  const extract::ExtractOptions options = options_of(field);
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  const FieldError whole = measure_field_error(mesh, field, options, in_windows(kOneWindow), Context()).value();
  expect_same(whole, measure_field_error(mesh, field, options, in_windows(700), Context()).value());
  expect_same(whole, measure_extraction_error(field, options, in_windows(700), Context()).value());
}

TEST(ErrorWindows, GiveTheSameFiguresOfRegionsAndCaps) {
  const field::ScalarField field = tube_field();
  extract::ExtractOptions options = options_of(field);
  options.region = field::IndexBox{{5, 9, 13}, {50, 60, 77}};
  const mesh::Mesh open = test::extract(field, options).mesh;
  const FieldError of_open = measure_field_error(open, field, options, in_windows(kOneWindow), Context()).value();
  expect_same(of_open, measure_field_error(open, field, options, in_windows(500), Context()).value());
  expect_same(of_open, measure_extraction_error(field, options, in_windows(500), Context()).value());
  options.cap = true;
  const mesh::Mesh closed = test::extract(field, options).mesh;
  const FieldError whole = measure_field_error(closed, field, options, in_windows(kOneWindow), Context()).value();
  EXPECT_GT(whole.cap_triangles, 0U);
  expect_same(whole, measure_field_error(closed, field, options, in_windows(500), Context()).value());
}

// Noise has thousands of components, many of which lie in several windows.
TEST(ErrorWindows, CountComponentsOfNoise) {
  const field::ScalarField field = test::random_field<std::uint8_t>({40, 37, 50}, 4, 256);
  extract::ExtractOptions options = options_of(field);
  options.iso = 199.5;
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const FieldError whole = measure_field_error(mesh, field, options, in_windows(kOneWindow), Context()).value();
  EXPECT_EQ(whole.coverage->components, components.count());
  const FieldError error = measure_extraction_error(field, options, in_windows(3000), Context()).value();
  expect_same(whole, error, 0.1);
  EXPECT_EQ(error.coverage->components, components.count());
}

// Without most of its components, the mesh is far from the isosurface in most windows, and missing in some.
TEST(ErrorWindows, FindFarMeshes) {
  const field::ScalarField field = tube_field();
  const extract::ExtractOptions options = options_of(field);
  mesh::Mesh mesh = test::extract(field, options).mesh;
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  for (const std::uint32_t kept : {0U, 2U, components.count() - 1}) {
    std::vector<glm::uvec3> triangles;
    for (const glm::uvec3& t : mesh.triangles) {
      if (components.of_vertex(t.x) == kept) triangles.push_back(t);
    }
    mesh::Mesh part;
    part.origin = mesh.origin;
    std::vector<glm::vec3> positions;
    std::vector<std::uint32_t> numbers(mesh.positions.size(), 0);
    for (glm::uvec3& t : triangles) {
      for (int c = 0; c < 3; ++c) {
        std::uint32_t& number = numbers[t[c]];
        if (number == 0) {
          positions.push_back(mesh.positions[t[c]]);
          number = static_cast<std::uint32_t>(positions.size());
        }
        t[c] = number - 1;
      }
    }
    part.positions = Buffer<glm::vec3>(positions.size());
    std::ranges::copy(positions, part.positions.begin());
    part.triangles = Buffer<glm::uvec3>(triangles.size());
    std::ranges::copy(triangles, part.triangles.begin());
    const FieldError whole = measure_field_error(part, field, options, in_windows(kOneWindow), Context()).value();
    EXPECT_EQ(whole.coverage->lost, components.count() - 1);
    EXPECT_GT(whole.coverage->distances.max.voxels, 10);
    expect_same(whole, measure_field_error(part, field, options, in_windows(600), Context()).value());
  }
}

// The nearest component of a vertex may lie in the bricks of another window, even of an earlier one.
TEST(ErrorWindows, FindComponentsOfOtherWindows) {
  const field::ScalarField field = tube_field();
  const extract::ExtractOptions options = options_of(field);
  for (const glm::vec3& move : {glm::vec3(0, 0, 31), glm::vec3(-9, 25, -28)}) {
    mesh::Mesh mesh = test::extract(field, options).mesh;
    for (glm::vec3& p : mesh.positions) p += move;
    const FieldError whole = measure_field_error(mesh, field, options, in_windows(kOneWindow), Context()).value();
    EXPECT_GT(whole.coverage->lost, 0U);
    expect_same(whole, measure_field_error(mesh, field, options, in_windows(1500), Context()).value());
  }
}

// A long triangle has points in many windows.
TEST(ErrorWindows, MeasureLongTriangles) {
  const field::ScalarField field =
      test::dense_field<double>({64, 48, 80}, [](int i, int, int k) { return i - 31 - (k == 45 ? 2 : 0) + k / 400.0; });
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::make_mesh("t", {{31, 1, 1}, {31, 46, 3}, {31, 20, 78}}, {{0, 1, 2}});
  const FieldError whole = measure_field_error(mesh, field, options, in_windows(kOneWindow), Context()).value();
  EXPECT_GT(whole.interior.points, 4000U);
  expect_same(whole, measure_field_error(mesh, field, options, in_windows(100), Context()).value());
}

// All points of a flat triangle in a grid plane count once, whatever bricks rounding puts them in.
TEST(ErrorWindows, MeasureAllPointsOfTrianglesBetweenBricks) {
  const field::ScalarField field = test::dense_field<double>({40, 40, 40}, [](int, int j, int) { return j - 16.25; });
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::make_mesh(
      "t", {{1, 16, 1}, {38, 16, 2}, {3, 16, 37}, {15.5F, 16, 15.2F}, {16.3F, 16, 15.7F}, {15.8F, 16, 16.4F}},
      {{0, 1, 2}, {3, 4, 5}});
  double points = 0;
  const auto count = [&](const TrianglePoint& /*point*/) { ++points; };
  for (const glm::uvec3& t : mesh.triangles) {
    for_each_point({glm::dvec3(mesh.positions[t.x]), glm::dvec3(mesh.positions[t.y]), glm::dvec3(mesh.positions[t.z])},
                   kLongestSide, count);
  }
  const FieldError error = measure_field_error(mesh, field, options, {}, Context()).value();
  EXPECT_EQ(static_cast<double>(error.interior.points), points);
  EXPECT_NEAR(error.interior.max.voxels, 0.25, 1e-9);
}

// Parts of the isosurface that were clipped away need no larger windows.
TEST(ErrorWindows, DoNotGrowBesideClips) {
  const field::ScalarField field =
      test::dense_field<float>({30, 30, 160}, [](int, int, int k) { return k % 2 == 0 ? 1 : -1; });
  const extract::ExtractOptions options = options_of(field);
  mesh::Mesh mesh = test::extract(field, options).mesh;
  constexpr float kClip = 139.9F;
  std::size_t kept = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh.positions[t.x].z > kClip) mesh.triangles[kept++] = t;
  }
  Buffer<glm::uvec3> triangles(kept);
  std::copy_n(mesh.triangles.begin(), kept, triangles.begin());
  mesh.triangles = std::move(triangles);
  const std::vector<mesh::HalfSpace> clipped{{{0, 0, 1}, kClip}};
  const auto measure = [&](std::uint64_t window_triangles) {
    FieldErrorOptions how = in_windows(window_triangles);
    how.clipped = clipped;
    const Context context;
    const FieldError error = measure_field_error(mesh, field, options, how, context).value();
    return std::pair(error, context.memory().peak());
  };
  const auto [whole, most] = measure(kOneWindow);
  const auto [error, least] = measure(20'000);
  expect_same(whole, error);
  EXPECT_EQ(error.coverage->components, 19U);
  EXPECT_LT(least, most / 2);
}

TEST(ErrorWindows, GiveTheSameFiguresOfResampledGrids) {
  const field::ScalarField field = tube_field();
  const field::ScalarField grid =
      field::resample(field, {40, 40, 50}, field::ResampleKernel::linear, field::NanHandling::left_out, Context())
          .value();
  extract::ExtractOptions options = options_of(grid);
  const mesh::Mesh mesh = test::extract(grid, options).mesh;
  FieldErrorOptions how = in_windows(kOneWindow);
  how.grid = &grid;
  const FieldError whole = measure_field_error(mesh, field, options, how, Context()).value();
  how.window_triangles = 800;
  expect_same(whole, measure_field_error(mesh, field, options, how, Context()).value());
}

TEST(ErrorWindows, TakeLessMemory) {
  const field::ScalarField field = test::dense_field<float>({33, 33, 160}, [](int i, int j, int k) {
    return std::sin(i / 3.0) * std::cos(j / 3.0) + std::sin(j / 3.0) * std::cos(k / 3.0) +
           std::sin(k / 3.0) * std::cos(i / 3.0);
  });
  const extract::ExtractOptions options = options_of(field);
  const auto peak = [&](std::uint64_t triangles) {
    const Context context;
    EXPECT_TRUE(measure_extraction_error(field, options, in_windows(triangles), context));
    return context.memory().peak();
  };
  EXPECT_LT(peak(5'000), peak(kOneWindow) / 2);
}

TEST(ErrorWindows, FailIfMemoryIsShort) {
  const field::ScalarField field = tube_field();
  const auto error = measure_extraction_error(field, options_of(field), in_windows(500), Context(MemoryBudget(300000)));
  ASSERT_FALSE(error);
  EXPECT_EQ(error.error().code, ErrorCode::out_of_memory);
}

TEST(ErrorWindows, DivideBricksAlongOneAxisAfterTheOther) {
  const std::vector<BrickCount> bricks{{{0, 0, -3}, 4}, {{0, 0, 0}, 6}, {{1, 0, 0}, 5}, {{0, 2, 0}, 4},
                                       {{5, 3, 0}, 9},  {{6, 3, 0}, 9}, {{0, 0, 1}, 2}, {{0, 0, 9}, 3}};
  const std::vector<WindowBricks> windows = divide_bricks(bricks, 11);
  ASSERT_EQ(windows.size(), 6U);
  constexpr int kFar = BrickBox::kUnbounded;
  EXPECT_EQ(windows[0].box.max, glm::ivec3(kFar, kFar, -1));
  EXPECT_EQ(windows[1].box.min, glm::ivec3(-kFar, -kFar, 0));
  EXPECT_EQ(windows[1].box.max, glm::ivec3(kFar, 1, 0));
  EXPECT_EQ(windows[1].count, 2U);
  EXPECT_EQ(windows[2].box.min, glm::ivec3(-kFar, 2, 0));
  EXPECT_EQ(windows[2].box.max, glm::ivec3(kFar, 2, 0));
  EXPECT_EQ(windows[3].box.max, glm::ivec3(5, kFar, 0));
  EXPECT_EQ(windows[3].box.min, glm::ivec3(-kFar, 3, 0));
  EXPECT_EQ(windows[4].box.min, glm::ivec3(6, 3, 0));
  EXPECT_EQ(windows[5].box.min, glm::ivec3(-kFar, -kFar, 1));
  EXPECT_EQ(windows[5].count, 2U);
}

}  // namespace
}  // namespace isoextract::accuracy

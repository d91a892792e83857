// Simplification in windows, for meshes that are too large to simplify as a whole.
#include "edit/detail/simplify_windows.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "accuracy/mesh_distance.hpp"
#include "field/demo_field.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/topology.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/simplify_promises.hpp"

namespace isoextract::edit {
namespace {

using test::expect_kept_promises;
using test::must_simplify;

field::ScalarField demo(const std::string& name) { return *field::make_demo_field(name, Context()); }

std::uint64_t count_pairs(const mesh::Mesh& mesh) { return mesh::find_self_intersections(mesh, {}, Context())->pairs; }

SimplifyOptions to_distance(double distance) {
  SimplifyOptions options;
  options.max_distance = distance;
  options.patch_size = 8;
  return options;
}

// A ball of radius 0.38 size whose samples have noise: folds, tunnels and thin sheets, without self-intersections.
mesh::Mesh noisy_ball(int size) {
  std::mt19937 engine(11);
  std::uniform_real_distribution<double> noise(-1.5, 1.5);
  const auto field = test::dense_field<float>({size, size, size}, [&](int i, int j, int k) {
    const glm::dvec3 from = glm::dvec3(i, j, k) - glm::dvec3(size / 2.0 + 0.3);
    return 0.38 * size - glm::length(from) + noise(engine);
  });
  extract::ExtractOptions options;
  options.method = extract::Method::mt;
  return test::extract(field, options).mesh;
}

TEST(SimplifyWindows, KeepPromisesOnSmoothSurfaces) {
  // The slabs of the first are thinner than a voxel, so that most triangles meet a plane.
  for (const std::uint64_t slab : {150U, 2500U, 20000U}) {
    test::SimplifyCase c;
    c.normals = true;
    c.slab_triangles = slab;
    c.max_distance = 0.1 * 2 / 47;
    c.patch_size = 24.0 * 2 / 47;
    const bool is_thin = slab < 1000;
    EXPECT_LT(expect_kept_promises(demo("demo:sphere?size=48"), c), is_thin ? 1 : 0.2);
    EXPECT_LT(expect_kept_promises(demo("demo:torus?size=48"), c), is_thin ? 1 : 0.3);
    c.cap = false;
    c.max_distance = 0.2 * 2 / 47;
    EXPECT_LT(expect_kept_promises(demo("demo:gyroid?size=48"), c), slab < 10000 ? 1 : 0.6);
  }
}

TEST(SimplifyWindows, KeepPromisesOnNoiseAndCheckerboards) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    test::SimplifyCase c;
    c.method = seed % 2 == 0 ? extract::Method::mc : extract::Method::mt;
    c.iso = 3.5;
    c.cap = seed % 4 < 3;
    c.max_distance = seed < 2 ? 0.1 : 1.0;
    c.slab_triangles = 200 << seed;
    expect_kept_promises(test::random_field<std::uint8_t>({14, 13, 12}, seed, 8), c);
    c.iso = 0.5;
    expect_kept_promises(test::dense_field<float>({10, 11, 12}, [](int i, int j, int k) { return (i + j + k) % 2; }),
                         c);
  }
}

// The distance limit is larger than a slab, so that windows reach over several slabs.
TEST(SimplifyWindows, KeepPromisesIfTheLimitIsWiderThanASlab) {
  for (const double distance : {0.3, 2.0, 6.0}) {
    test::SimplifyCase c;
    c.iso = 0.5;
    c.max_distance = distance;
    c.slab_triangles = 400;
    const auto tubes = test::dense_field<std::uint8_t>(
        {24, 24, 30}, [](int i, int j, int k) { return (i % 6 == 3) + (j % 6 == 3) + (k % 6 == 3) >= 2; });
    expect_kept_promises(tubes, c);
    const auto shell = test::dense_field<float>({24, 24, 24}, [](int i, int j, int k) {
      const double r = std::sqrt(std::pow(i - 11.5, 2) + std::pow(j - 11.5, 2) + std::pow(k - 11.5, 2));
      return std::max(0.0, 1 - std::abs(r - 8));
    });
    expect_kept_promises(shell, c);
    const auto plate = test::dense_field<std::uint8_t>({24, 24, 24}, [](int i, int, int) { return i == 7; });
    expect_kept_promises(plate, c);
  }
}

TEST(SimplifyWindows, KeepPromisesInAnisotropicObliqueMirroredAndFarFrames) {
  for (const glm::dvec3 far : {glm::dvec3(0), glm::dvec3(1e7, -1e7, 1e7)}) {
    field::ScalarField field = demo("demo:torus?size=40");
    field.index_to_world = {glm::dmat3(-0.5, 0.1, 0, 0.2, 3, 0, 0, 0.7, 20), far};
    test::SimplifyCase c;
    c.max_distance = 0.1;
    c.to_metric = glm::inverse(field.index_to_world.linear);
    c.patch_size = 12;
    c.slab_triangles = 500;
    EXPECT_LT(expect_kept_promises(field, c), 0.6);
  }
}

// No plane between slabs stays visible as a line of vertices.
TEST(SimplifyWindows, LeaveAboutAsManyTrianglesAsTheWhole) {
  extract::ExtractOptions options;
  options.cap = true;
  const mesh::Mesh gyroid = test::extract(demo("demo:gyroid?size=64"), options).mesh;
  SimplifyOptions simplify = to_distance(0.1 * 2 / 63);
  simplify.patch_size = 32.0 * 2 / 63;
  const std::size_t whole = must_simplify(copy(gyroid), simplify).mesh.triangles.size();
  const SimplifiedMesh windows = must_simplify(copy(gyroid), simplify, gyroid.triangles.size() / 8);
  EXPECT_GE(windows.facts.windows, 8U);
  EXPECT_LT(static_cast<double>(windows.mesh.triangles.size()), 1.03 * static_cast<double>(whole));
  EXPECT_GT(windows.facts.distance_lower, 0.9 * simplify.max_distance);

  // A flat side keeps a few vertices for each slab, not one for each voxel along the plane.
  const auto box = test::dense_field<float>({64, 64, 64}, [](int i, int j, int k) {
    return 25.0 - std::max({std::abs(i - 32.0), std::abs(j - 32.0), std::abs(k - 32.0)});
  });
  options.iso = 0;
  const mesh::Mesh cube = test::extract(box, options).mesh;
  const SimplifiedMesh simple = must_simplify(copy(cube), to_distance(0.1), cube.triangles.size() / 6);
  EXPECT_GE(simple.facts.windows, 6U);
  EXPECT_LT(simple.mesh.triangles.size(), 200U);
}

// Heights prove the distances of smooth surfaces, and find no lower bounds.
TEST(SimplifyWindows, ReportLowerBoundsNearUpperBounds) {
  for (const double distance : {0.001, 0.01}) {
    const SimplifiedMesh done = must_simplify(test::sphere(30, false), to_distance(distance), 800);
    EXPECT_GE(done.facts.windows, 4U);
    EXPECT_GT(done.facts.distance_upper, 0.5 * distance);
    EXPECT_LE(done.facts.distance_upper, distance);
    EXPECT_GE(done.facts.distance_lower, 0.8 * done.facts.distance_upper) << distance;
    accuracy::DistanceOptions measure;
    measure.samples = 0;
    const auto exact = accuracy::measure_distance(test::sphere(30, false), done.mesh, measure, Context());
    EXPECT_LE(done.facts.distance_lower, exact->hausdorff_upper + exact->resolution);
  }
}

TEST(SimplifyWindows, MakeNoTrianglesIntersect) {
  const mesh::Mesh noisy = noisy_ball(40);
  ASSERT_EQ(count_pairs(noisy), 0U);
  for (const double distance : {0.1, 0.7, 3.0}) {
    const SimplifiedMesh done = must_simplify(copy(noisy), to_distance(distance), noisy.triangles.size() / 7);
    EXPECT_GE(done.facts.windows, 6U);
    EXPECT_LT(done.mesh.triangles.size(), noisy.triangles.size());
    EXPECT_EQ(count_pairs(done.mesh), 0U) << distance;
    EXPECT_LE(done.facts.distance_upper, distance);
    test::expect_sound(done.mesh, false);
  }
}

TEST(SimplifyWindows, AreIndependentOfThreads) {
  const mesh::Mesh noisy = noisy_ball(32);
  const auto simplified_by = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return must_simplify(copy(noisy), to_distance(0.5), noisy.triangles.size() / 5);
  };
  const SimplifiedMesh one = simplified_by(1);
  const SimplifiedMesh several = simplified_by(4);
  EXPECT_TRUE(std::ranges::equal(one.mesh.triangles, several.mesh.triangles));
  EXPECT_TRUE(std::ranges::equal(one.mesh.positions, several.mesh.positions));
  EXPECT_EQ(one.facts.distance_lower, several.facts.distance_lower);
  EXPECT_EQ(one.facts.distance_upper, several.facts.distance_upper);
}

// Triangles in any order, of which some are longer than a slab.
TEST(SimplifyWindows, TakeMeshesOfAnyOrderAndShape) {
  mesh::Mesh ball = test::sphere(40, false);
  std::mt19937 engine(3);
  std::shuffle(ball.triangles.begin(), ball.triangles.end(), engine);
  for (glm::vec3& p : ball.positions) p.x *= 0.01F;
  for (const double distance : {0.001, 0.1}) {
    const SimplifiedMesh done = must_simplify(copy(ball), to_distance(distance), 300);
    EXPECT_LT(done.mesh.triangles.size(), ball.triangles.size());
    EXPECT_LE(done.facts.distance_upper, distance);
    test::expect_sound(done.mesh, true);
  }
  // Simplified once more, most triangles reach over many slabs.
  const auto box = test::dense_field<float>({64, 32, 32}, [](int i, int j, int k) {
    return 11.3 - std::max({std::abs(i - 32.0) - 16, std::abs(j - 16.0), std::abs(k - 16.0)});
  });
  extract::ExtractOptions options;
  const SimplifiedMesh simple = must_simplify(test::extract(box, options).mesh, to_distance(0.05));
  const SimplifiedMesh again = must_simplify(copy(simple.mesh), to_distance(0.2), 8);
  EXPECT_LE(again.mesh.triangles.size(), simple.mesh.triangles.size());
  test::expect_sound(again.mesh, true);
}

TEST(SimplifyWindows, KeepVertexAttributes) {
  mesh::Mesh before = test::sphere(40, true);
  test::add_color(before, mesh::ComponentType::u8, 3);
  const mesh::Mesh after = must_simplify(copy(before), to_distance(0.05), 1000).mesh;
  ASSERT_LT(after.positions.size(), before.positions.size());
  EXPECT_EQ(after.normals.size(), after.positions.size());
  EXPECT_EQ(after.attributes.at(0).values.size(), after.positions.size() * before.attributes.at(0).stride());
}

// A budget that does not hold the buffers of the whole mesh leads to windows; one that holds no window is refused.
TEST(SimplifyWindows, FollowTheMemoryBudget) {
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::extract(demo("demo:gyroid?size=96"), options).mesh;
  SimplifyOptions simplify = to_distance(0.1 * 2 / 95);
  simplify.patch_size = 32.0 * 2 / 95;
  const auto with = [&](std::uint64_t mib) {
    const Context context{MemoryBudget(mib << 20)};
    return simplify_mesh(copy(mesh), simplify, context);
  };
  const auto whole = with(1024);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->facts.windows, 0U);
  const auto in_windows = with(96);
  ASSERT_TRUE(in_windows) << in_windows.error().message;
  EXPECT_GT(in_windows->facts.windows, 4U);
  EXPECT_LE(in_windows->facts.distance_upper, simplify.max_distance);
  const auto refused = with(16);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
}

// With a target, windows bring the mesh near it; then the rest is simplified as a whole, as if nothing had happened
// before.
TEST(SimplifyWindows, ApproachATargetNumber) {
  extract::ExtractOptions options;
  const mesh::Mesh mesh = test::extract(demo("demo:gyroid?size=64"), options).mesh;
  SimplifyOptions simplify;
  simplify.max_distance = std::numeric_limits<double>::infinity();
  simplify.patch_size = 32.0 * 2 / 63;
  const auto with = [&](std::uint64_t mib, std::uint64_t triangles) {
    simplify.triangles = triangles;
    const Context context{MemoryBudget(mib << 20)};
    return simplify_mesh(copy(mesh), simplify, context);
  };
  const auto whole = with(1024, 15000);
  const auto limited = with(48, 15000);
  ASSERT_TRUE(whole);
  ASSERT_TRUE(limited) << limited.error().message;
  EXPECT_EQ(whole->facts.windows, 0U);
  EXPECT_GT(limited->facts.windows, 2U);
  EXPECT_EQ(limited->facts.triangles_before, mesh.triangles.size());
  for (const auto* result : {&*whole, &*limited}) {
    EXPECT_GE(result->mesh.triangles.size(), 14999U);
    EXPECT_LE(result->mesh.triangles.size(), 15000U);
  }
  EXPECT_LT(limited->facts.distance_upper, 1.5 * whole->facts.distance_upper);
  test::expect_sound(limited->mesh, false);
  accuracy::DistanceOptions measure;
  measure.samples = 0;
  const auto distance = accuracy::measure_distance(mesh, limited->mesh, measure, Context());
  EXPECT_LE(distance->hausdorff_lower, limited->facts.distance_upper + distance->resolution);
  EXPECT_LE(limited->facts.distance_lower, distance->hausdorff_upper + distance->resolution);
  // Windows would not bring the mesh to a size that fits.
  const auto refused = with(48, 75000);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
}

TEST(SimplifyWindows, EndIfCancelled) {
  const Context cancelled;
  cancelled.cancel();
  mesh::Mesh ball = test::sphere(40, false);
  SimplifyFigures facts;
  const auto ended = simplify_in_windows(ball, to_distance(0.05), 1000, facts, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace isoextract::edit

#include "edit/smooth.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "field/demo_field.hpp"
#include "mesh/metrics.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

SmoothFigures must_smooth(mesh::Mesh& mesh, const SmoothOptions& options) {
  const auto facts = smooth(mesh, options, Context());
  if (!facts) throw std::runtime_error(facts.error().message);
  return *facts;
}

// A sphere of this radius whose distances have noise of up to half a voxel.
field::ScalarField noisy_sphere(double radius) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> noise(-0.5, 0.5);
  return test::dense_field<float>(glm::ivec3(48), [&](int i, int j, int k) {
    return radius - glm::length(glm::dvec3(i - 23.3, j - 23.4, k - 23.6)) + noise(engine);
  });
}

mesh::Mesh rough_surface(const field::ScalarField& field, bool cap, bool normals = false) {
  extract::ExtractOptions options;
  options.cap = cap;
  options.smooth_normals = normals;
  return std::move(test::extract(field, options).mesh);
}

// Returns the root mean square distance of the vertices to a sphere.
double roughness(const mesh::Mesh& mesh, double radius) {
  double sum = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double off = glm::length(mesh.position(v) - glm::dvec3(23.3, 23.4, 23.6)) - radius;
    sum += off * off;
  }
  return std::sqrt(sum / static_cast<double>(mesh.positions.size()));
}

// Returns the root mean square angle, in radians, between the vertex normals and those of the sphere.
double normal_error(const mesh::Mesh& mesh) {
  double sum = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 outward = glm::normalize(mesh.position(v) - glm::dvec3(23.3, 23.4, 23.6));
    const double angle = std::acos(std::clamp(glm::dot(glm::dvec3(mesh.normals[v]), outward), -1.0, 1.0));
    sum += angle * angle;
  }
  return std::sqrt(sum / static_cast<double>(mesh.positions.size()));
}

SmoothOptions weighted(std::uint64_t passes, std::span<const float> weights) {
  SmoothOptions options;
  options.method = SmoothMethod::weighted;
  options.passes = passes;
  options.weights = weights;
  return options;
}

TEST(WeightedSmooth, MovesVerticesByTheirWeights) {
  const field::ScalarField field = noisy_sphere(18);
  mesh::Mesh mesh = rough_surface(field, false, true);
  const mesh::Mesh before = copy(mesh);
  std::vector<float> weights(mesh.positions.size(), 1);
  for (std::size_t v = 0; v < weights.size(); ++v) {
    if (mesh.position(v).x < 23) weights[v] = 0;
  }
  const SmoothFigures facts = must_smooth(mesh, weighted(25, weights));
  test::expect_sound(mesh, true);
  ASSERT_TRUE(facts.mean_weight);
  EXPECT_NEAR(*facts.mean_weight, 0.5, 0.05);
  double moved = 0;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    if (weights[v] == 0) {
      EXPECT_EQ(mesh.positions[v], before.positions[v]);
    }
    moved += weights[v] > 0 && mesh.positions[v] != before.positions[v] ? 1 : 0;
  }
  EXPECT_GT(moved, 0.45 * static_cast<double>(weights.size()));
  EXPECT_LT(roughness(mesh, 18), 0.8 * roughness(before, 18));
}

// A plain mean of neighbors takes a tenth of this sphere, and more of smaller ones.
TEST(WeightedSmooth, KeepsTheVolumeOfEachClosedComponent) {
  for (const double radius : {8.0, 18.0}) {
    mesh::Mesh mesh = rough_surface(noisy_sphere(radius), false);
    const mesh::Mesh before = copy(mesh);
    const std::vector<float> weights(mesh.positions.size(), 1);
    const SmoothFigures facts = must_smooth(mesh, weighted(25, weights));
    test::expect_sound(mesh, true);
    EXPECT_NEAR(facts.volume_after / facts.volume_before, 1, 1e-3) << radius;
    EXPECT_LT(roughness(mesh, radius), roughness(before, radius));
  }
}

// The means of an octahedron's vertices are its center.
TEST(WeightedSmooth, KeepsComponentsThatWouldCollapse) {
  const std::vector<glm::vec3> corners{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const std::vector<glm::uvec3> octahedron{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4},
                                           {1, 0, 5}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  mesh::Mesh mesh = test::make_mesh("octahedron", corners, octahedron);
  const std::vector<float> weights(6, 1);
  EXPECT_EQ(must_smooth(mesh, weighted(25, weights)).greatest_move, 0);
}

TEST(WeightedSmooth, KeepsCapsInTheirPlane) {
  const field::ScalarField field = field::make_demo_field("demo:gyroid?size=24", Context()).value();
  mesh::Mesh mesh = rough_surface(field, true);
  const mesh::Mesh before = copy(mesh);
  const std::vector<float> weights(mesh.positions.size(), 1);
  SmoothOptions options = weighted(10, weights);
  options.walls = DataBox{glm::dmat3(1), glm::dvec3(0), glm::dvec3(0), glm::dvec3(23)};
  must_smooth(mesh, options);
  std::size_t on_sides = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double was = before.position(v)[axis];
      if (std::abs(was) > 1e-4 && std::abs(was - 23) > 1e-4) continue;
      EXPECT_NEAR(mesh.position(v)[axis], was, 1e-5);
      ++on_sides;
    }
  }
  EXPECT_GT(on_sides, 100U);
}

// Two passes on paper: a vertex of a closed fan moves to the mean of its neighbors, and then to the mean of where they
// moved.
TEST(WeightedSmooth, MatchesTheLaplacianStepOfThePaper) {
  const std::vector<glm::vec3> corners{{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  const std::vector<glm::uvec3> octahedron{{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {2, 1, 5}, {3, 2, 5}, {0, 3, 5}};
  mesh::Mesh mesh = test::make_mesh("octahedron", corners, octahedron);
  const std::vector<float> weights{0.5F, 0.5F, 0.5F, 0.5F, 0.25F, 0};
  must_smooth(mesh, weighted(2, weights));
  // z of the equator: 0, (1 - 1) / 4 = 0, then half of (0.75 - 1) / 4; of the pole: 1, 0.75, 0.75 * 0.75. The open edge
  // at the lower pole fixes vertices 0, 1 and 5, so that the volume is not restored.
  EXPECT_NEAR(mesh.position(2).z, 0.5 * -0.25 / 4, 1e-6);
  EXPECT_NEAR(mesh.position(4).z, 0.5625, 1e-6);
  EXPECT_EQ(mesh.position(5).z, -1);
}

TEST(WeightedSmooth, GivesBetterNormalsThanTheTriangles) {
  mesh::Mesh mesh = rough_surface(noisy_sphere(18), false, true);
  const std::vector<float> weights(mesh.positions.size(), 0.8F);
  must_smooth(mesh, weighted(25, weights));
  // Weights of 0 leave the normals of the triangles.
  mesh::Mesh triangles = copy(mesh);
  const std::vector<float> none(mesh.positions.size(), 0);
  must_smooth(triangles, weighted(1, none));
  EXPECT_LT(normal_error(mesh), 0.8 * normal_error(triangles));
  for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1, 1e-6);
}

TEST(WeightedSmooth, IsIndependentOfThreads) {
  std::vector<mesh::Mesh> made;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    mesh::Mesh mesh = rough_surface(noisy_sphere(18), false, true);
    std::vector<float> weights(mesh.positions.size());
    for (std::size_t v = 0; v < weights.size(); ++v) weights[v] = static_cast<float>(v % 17) / 16;
    must_smooth(mesh, weighted(10, weights));
    made.push_back(std::move(mesh));
  }
  for (const mesh::Mesh& mesh : made) {
    EXPECT_TRUE(std::ranges::equal(mesh.positions, made.front().positions));
    EXPECT_TRUE(std::ranges::equal(mesh.normals, made.front().normals));
  }
}

class SmoothMethods : public testing::TestWithParam<SmoothMethod> {};
INSTANTIATE_TEST_SUITE_P(Smooth, SmoothMethods, testing::Values(SmoothMethod::taubin, SmoothMethod::sinc),
                         [](const auto& parameter) { return std::string(word_of(parameter.param)); });

TEST_P(SmoothMethods, RemovesNoiseAndKeepsSize) {
  mesh::Mesh mesh = rough_surface(noisy_sphere(18), false, true);
  const mesh::Mesh before = copy(mesh);
  SmoothOptions options;
  options.method = GetParam();
  const SmoothFigures facts = must_smooth(mesh, options);
  test::expect_sound(mesh, true);
  EXPECT_TRUE(std::ranges::equal(mesh.triangles, before.triangles));
  EXPECT_LT(roughness(mesh, 18), 0.6 * roughness(before, 18));
  EXPECT_NEAR(facts.volume_after / facts.volume_before, 1, 0.01);
  EXPECT_DOUBLE_EQ(facts.volume_after, mesh::measure_size(mesh).volume);
  EXPECT_EQ(facts.boundary_vertices, 0U);
  EXPECT_EQ(facts.vertices, mesh.positions.size());
  double most = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    most = std::max(most,
                    static_cast<double>(glm::length(glm::dvec3(mesh.positions[v]) - glm::dvec3(before.positions[v]))));
    const glm::dvec3 outward = glm::normalize(mesh.position(v) - glm::dvec3(23.3, 23.4, 23.6));
    EXPECT_GT(glm::dot(glm::dvec3(mesh.normals[v]), outward), 0.4);
    EXPECT_NEAR(glm::length(mesh.normals[v]), 1, 1e-6);
  }
  EXPECT_DOUBLE_EQ(facts.greatest_move_world, most);
  EXPECT_GT(most, 0.1);
  EXPECT_LT(most, 2);
}

// The filter damps a wave by its gain. On this torus all vertices have six neighbors in the same directions, so the
// frequency of a wave is known.
TEST_P(SmoothMethods, DampsWaveByItsGain) {
  constexpr unsigned kSide = 24;
  std::vector<glm::uvec3> triangles;
  const auto vertex = [](unsigned a, unsigned b) { return a % kSide * kSide + b % kSide; };
  for (unsigned a = 0; a < kSide; ++a) {
    for (unsigned b = 0; b < kSide; ++b) {
      triangles.emplace_back(vertex(a, b), vertex(a + 1, b), vertex(a + 1, b + 1));
      triangles.emplace_back(vertex(a, b), vertex(a + 1, b + 1), vertex(a, b + 1));
    }
  }
  for (const unsigned wave : {0U, 1U, 2U, 5U, 12U}) {
    const double turn = 2 * std::numbers::pi * wave / kSide;
    std::vector<glm::vec3> positions;
    for (unsigned a = 0; a < kSide; ++a) {
      for (unsigned b = 0; b < kSide; ++b) positions.emplace_back(std::cos(turn * a), 0, 0);
    }
    mesh::Mesh mesh = test::make_mesh("torus", positions, triangles);
    SmoothOptions options;
    options.method = GetParam();
    options.passes = 15;
    options.pass_band = 0.15;
    must_smooth(mesh, options);
    // Two of the six neighbors have the same phase, two are a step ahead, two a step behind.
    const double frequency = 1 - (2 + 4 * std::cos(turn)) / 6;
    EXPECT_NEAR(mesh.positions[0].x, smoothing_gain(options, frequency), 1e-5) << wave;
    if (wave == 0) {
      EXPECT_EQ(mesh.positions[0].x, 1) << "what does not vary stays";
    }
  }
  SmoothOptions options;
  options.method = GetParam();
  EXPECT_NEAR(smoothing_gain(options, options.pass_band), 1, 0.01);
  EXPECT_LT(std::abs(smoothing_gain(options, 1.5)), 0.01);
}

TEST_P(SmoothMethods, KeepsVerticesOnBoundaryEdges) {
  const field::ScalarField field = field::make_demo_field("demo:gyroid?size=32", Context()).value();
  mesh::Mesh mesh = rough_surface(field, false);
  const mesh::Mesh before = copy(mesh);
  SmoothOptions options;
  options.method = GetParam();
  const SmoothFigures facts = must_smooth(mesh, options);
  test::expect_sound(mesh, false);
  std::vector<int> uses(mesh.positions.size());
  std::size_t stayed = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3 p = before.positions[v];
    const bool at_data_boundary = glm::any(glm::equal(p, glm::vec3(mesh::measure_local_bounds(before).min))) ||
                                  glm::any(glm::equal(p, glm::vec3(mesh::measure_local_bounds(before).max)));
    if (!at_data_boundary) continue;
    EXPECT_EQ(mesh.positions[v], p);
    ++stayed;
  }
  EXPECT_EQ(facts.boundary_vertices, stayed);
  EXPECT_GT(stayed, 100U);
}

TEST_P(SmoothMethods, KeepsCapsFlat) {
  const field::ScalarField field = field::make_demo_field("demo:gyroid?size=32", Context()).value();
  extract::ExtractOptions extract;
  extract.cap = true;
  extract.output_from_index = field::Affine{glm::dmat3(2, 0.3, 0, 0.5, 1, 0.2, 0, -0.4, 1.5), glm::dvec3(5, -3, 2)};
  mesh::Mesh mesh = std::move(test::extract(field, extract).mesh);
  const field::Affine to_index = extract.output_from_index.inverse();
  const auto on_side = [&](double x) { return std::abs(x) < 1e-4 || std::abs(x - 31) < 1e-4; };
  const mesh::Mesh before = copy(mesh);
  SmoothOptions options;
  options.method = GetParam();
  options.walls = DataBox{to_index.linear, to_index.offset, glm::dvec3(0), glm::dvec3(31)};
  const SmoothFigures facts = must_smooth(mesh, options);
  test::expect_sound(mesh, true);
  std::size_t on_sides = 0;
  bool moved = false;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 was = to_index(before.position(v));
    const glm::dvec3 is = to_index(mesh.position(v));
    bool any = false;
    for (int axis = 0; axis < 3; ++axis) {
      if (!on_side(was[axis])) continue;
      EXPECT_NEAR(is[axis], was[axis], 1e-5);
      any = true;
    }
    on_sides += any ? 1 : 0;
    moved = moved || (any && glm::length(is - was) > 0.01);
  }
  EXPECT_EQ(facts.wall_vertices, on_sides);
  EXPECT_TRUE(moved) << "along the side they may";
  EXPECT_NEAR(facts.volume_after / facts.volume_before, 1, 0.01);
}

TEST_P(SmoothMethods, IsIndependentOfThreads) {
  std::vector<mesh::Mesh> results;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(rough_surface(noisy_sphere(18), true, true));
    SmoothOptions options;
    options.method = GetParam();
    must_smooth(results.back(), options);
  }
  EXPECT_TRUE(std::ranges::equal(results[0].positions, results[1].positions));
  EXPECT_TRUE(std::ranges::equal(results[0].normals, results[1].normals));
}

TEST(Smooth, CountsTrianglesWithoutArea) {
  mesh::Mesh mesh = rough_surface(noisy_sphere(12), false);
  const SmoothFigures sound = must_smooth(mesh, {});
  EXPECT_EQ(sound.zero_area_before, 0U);
  EXPECT_EQ(sound.zero_area_after, mesh::measure_size(mesh).zero_area_triangles);
  // Boundary vertices stay on their line.
  mesh::Mesh line;
  line.positions = Buffer<glm::vec3>(3);
  for (std::uint32_t v = 0; v < 3; ++v) line.positions[v] = glm::vec3(static_cast<float>(v), 0, 0);
  line.triangles = Buffer<glm::uvec3>(1);
  line.triangles[0] = {0, 1, 2};
  const SmoothFigures flat = must_smooth(line, {});
  EXPECT_EQ(flat.zero_area_before, 1U);
  EXPECT_EQ(flat.zero_area_after, 1U);
}

TEST(Smooth, LeavesMeshUnchangedIfMemoryIsShort) {
  mesh::Mesh mesh = rough_surface(noisy_sphere(12), false);
  const mesh::Mesh before = copy(mesh);
  const auto little = smooth(mesh, {}, Context(MemoryBudget(1000)));
  ASSERT_FALSE(little);
  EXPECT_EQ(little.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(std::ranges::equal(mesh.positions, before.positions));
  const Context cancelled;
  cancelled.cancel();
  EXPECT_EQ(smooth(mesh, {}, cancelled).error().code, ErrorCode::cancelled);
  mesh::Mesh empty;
  EXPECT_TRUE(smooth(empty, {}, Context()).has_value());
}

}  // namespace
}  // namespace isoextract::edit

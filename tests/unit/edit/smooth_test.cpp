#include "edit/smooth.hpp"

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
  EXPECT_EQ(facts.border_vertices, 0U);
  EXPECT_EQ(facts.vertices, mesh.positions.size());
  double most = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    most = std::max(most,
                    static_cast<double>(glm::length(glm::dvec3(mesh.positions[v]) - glm::dvec3(before.positions[v]))));
    const glm::dvec3 outward = glm::normalize(mesh.position(v) - glm::dvec3(23.3, 23.4, 23.6));
    EXPECT_GT(glm::dot(glm::dvec3(mesh.normals[v]), outward), 0.4);
    EXPECT_NEAR(glm::length(mesh.normals[v]), 1, 1e-6);
  }
  EXPECT_DOUBLE_EQ(facts.max_displacement_world, most);
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

TEST_P(SmoothMethods, KeepsOpenBorders) {
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
    const bool at_border = glm::any(glm::equal(p, glm::vec3(mesh::measure_local_bounds(before).min))) ||
                           glm::any(glm::equal(p, glm::vec3(mesh::measure_local_bounds(before).max)));
    if (!at_border) continue;
    EXPECT_EQ(mesh.positions[v], p);
    ++stayed;
  }
  EXPECT_EQ(facts.border_vertices, stayed);
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

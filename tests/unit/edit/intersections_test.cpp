// Simplification and smoothing make no triangles intersect that did not before.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "edit/bounded_simplify.hpp"
#include "edit/detail/collapse_state.hpp"
#include "edit/detail/edge_collapse.hpp"
#include "edit/detail/intersection_undo.hpp"
#include "edit/detail/surface_change.hpp"
#include "edit/smooth.hpp"
#include "edit/untangle.hpp"
#include "mesh/join_meshes.hpp"
#include "mesh/self_intersections.hpp"
#include "mesh/topology.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

std::uint64_t count_pairs(const mesh::Mesh& mesh) {
  const auto found = mesh::find_self_intersections(mesh, {}, Context());
  if (!found) throw std::runtime_error(found.error().message);
  return found->pairs;
}

// A ball whose distances have noise of up to 1.5 voxels: folds, tunnels and thin sheets. Marching tetrahedra leave no
// triangles that intersect.
mesh::Mesh noisy_ball(int size) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> noise(-1.5, 1.5);
  const glm::dvec3 center(size / 2.0 + 0.3);
  const field::ScalarField field = test::dense_field<float>(glm::ivec3(size), [&](int i, int j, int k) {
    return size / 2.0 - 4 - glm::length(glm::dvec3(i, j, k) - center) + noise(engine);
  });
  extract::ExtractOptions options;
  options.method = extract::Method::mt;
  return std::move(test::extract(field, options).mesh);
}

SimplifiedMesh simplified_copy(const mesh::Mesh& mesh, const SimplifyOptions& options) {
  auto simplified = simplify_mesh(copy(mesh), options, Context());
  if (!simplified) throw std::runtime_error(simplified.error().message);
  return std::move(*simplified);
}

SimplifyOptions to_distance(double distance) {
  SimplifyOptions options;
  options.max_distance = distance;
  options.patch_size = 8;
  return options;
}

SimplifyOptions to_count(std::uint64_t triangles) {
  SimplifyOptions options = to_distance(std::numeric_limits<double>::infinity());
  options.triangles = triangles;
  return options;
}

TEST(SimplifyIntersections, AddsNone) {
  const mesh::Mesh noisy = noisy_ball(40);
  ASSERT_EQ(count_pairs(noisy), 0U);
  for (const SimplifyOptions& options : {to_count(noisy.triangles.size() / 8), to_distance(0.7)}) {
    const SimplifiedMesh done = simplified_copy(noisy, options);
    EXPECT_LT(done.mesh.triangles.size(), noisy.triangles.size() / 2);
    EXPECT_EQ(count_pairs(done.mesh), 0U);
    EXPECT_GT(done.facts.refused_collapses, 0U);
    test::expect_sound(done.mesh, false);
  }
}

// The distance is small for the size of the patches, so the first round has no guard. The ball has many patches, or
// one.
TEST(SimplifyIntersections, AddsNoneAfterRoundWithoutGuard) {
  const mesh::Mesh noisy = noisy_ball(40);
  for (const double patch_size : {16.0, 400.0}) {
    SimplifyOptions options = to_distance(patch_size / 310);
    options.patch_size = patch_size;
    const SimplifiedMesh done = simplified_copy(noisy, options);
    EXPECT_LT(done.mesh.triangles.size(), noisy.triangles.size()) << patch_size;
    EXPECT_EQ(count_pairs(done.mesh), 0U) << patch_size;
    EXPECT_GT(done.facts.untangled_collapses, 0U) << patch_size;
    EXPECT_GT(done.facts.rounds, 1U) << patch_size;
    EXPECT_LE(done.facts.distance_upper, options.max_distance);
    test::expect_sound(done.mesh, false);
  }
}

TEST(SimplifyIntersections, AddsNoneBetweenPatchesOfThinSheets) {
  // Two shells a twentieth of a voxel apart. Their patches meet in many places.
  const mesh::Mesh outer = test::sphere(40, false);
  mesh::Mesh inner = copy(outer);
  const mesh::Bounds bounds = mesh::measure_bounds(outer);
  const glm::vec3 center = 0.5F * glm::vec3(bounds.min + bounds.max) - glm::vec3(outer.origin);
  for (glm::vec3& p : inner.positions) p = center + 0.997F * (p - center);
  for (glm::uvec3& t : inner.triangles) std::swap(t.y, t.z);
  std::array<mesh::Mesh, 2> shells{copy(outer), std::move(inner)};
  const mesh::Mesh both = std::move(*mesh::join_meshes(shells, Context()));
  ASSERT_EQ(count_pairs(both), 0U);
  for (const double distance : {0.05, 0.3}) {
    const SimplifiedMesh done = simplified_copy(both, to_distance(distance));
    EXPECT_LT(done.mesh.triangles.size(), both.triangles.size());
    EXPECT_EQ(count_pairs(done.mesh), 0U) << distance;
    EXPECT_LE(done.facts.distance_upper, distance);
  }
}

// Two bodies touch at three positions, each with its own vertices there. Flattening both of the pits between these
// positions would leave one triangle twice.
TEST(SimplifyIntersections, LeavesNoDuplicateTriangleWithoutGuard) {
  constexpr float kDepth = 0.02F;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (const float up : {1.0F, -1.0F}) {
    const auto v = static_cast<unsigned>(positions.size());
    positions.insert(positions.end(), {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, kDepth * up}, {1, 1, 4 * up}});
    for (unsigned i = 0; i < 3; ++i) {
      const unsigned from = v + (up > 0 ? i : (i + 1) % 3);
      const unsigned to = v + (up > 0 ? (i + 1) % 3 : i);
      triangles.insert(triangles.end(), {{to, from, v + 3}, {from, to, v + 4}});
    }
  }
  const mesh::Mesh both = test::make_mesh("bodies that touch", positions, triangles);
  ASSERT_EQ(count_pairs(both), 0U);
  SimplifyOptions options = to_distance(0.05);
  options.patch_size = 32;
  const SimplifiedMesh done = simplified_copy(both, options);
  const auto found = mesh::find_self_intersections(done.mesh, {}, Context());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->duplicate_triangles, 0U);
  EXPECT_EQ(found->pairs, 0U);
  EXPECT_EQ(done.mesh.triangles.size(), 10U);  // one pit stays
  EXPECT_GT(done.facts.untangled_collapses, 0U);
}

// A bowl in one patch, and needles whose tips are just above it. No needle can change, and all of them are in other
// patches. The distance is small enough for a single sweep.
TEST(SimplifyIntersections, AddsNoneWithUnchangedTrianglesOfOtherPatches) {
  constexpr unsigned kSide = 31;
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (unsigned v = 0; v < kSide * kSide; ++v) {
    const float x = 0.25F * static_cast<float>(v % kSide);
    const float y = 0.25F * static_cast<float>(v / kSide);
    positions.emplace_back(x, y, ((x - 3.75F) * (x - 3.75F) + (y - 3.75F) * (y - 3.75F)) / 20);
    if (v % kSide + 1 == kSide || v / kSide + 1 == kSide) continue;
    triangles.insert(triangles.end(), {{v, v + 1, v + kSide + 1}, {v, v + kSide + 1, v + kSide}});
  }
  for (unsigned v = 5 * (kSide + 1); v < kSide * (kSide - 5); v += 37) {
    if (v % kSide < 5 || v % kSide > kSide - 5) continue;
    const auto tip = static_cast<unsigned>(positions.size());
    const glm::vec3 at = positions[v] + glm::vec3(0, 0, 0.005F);
    const glm::vec3 top(at.x, at.y, 30);
    positions.insert(positions.end(), {at, top, top + glm::vec3(0.1F, 0, 0), top + glm::vec3(0, 0.1F, 0)});
    triangles.insert(
        triangles.end(),
        {{tip, tip + 2, tip + 1}, {tip, tip + 3, tip + 2}, {tip, tip + 1, tip + 3}, {tip + 1, tip + 2, tip + 3}});
  }
  const mesh::Mesh both = test::make_mesh("bowl", positions, triangles);
  ASSERT_EQ(count_pairs(both), 0U);
  const SimplifiedMesh done = simplified_copy(both, to_distance(0.05));
  EXPECT_LT(done.mesh.triangles.size(), both.triangles.size() / 2);
  EXPECT_EQ(count_pairs(done.mesh), 0U);
  EXPECT_GT(done.facts.untangled_collapses, 0U);
}

TEST(SimplifyIntersections, AddsNoneToPlantedPairs) {
  const mesh::Mesh ball = test::sphere(32, false);
  mesh::Mesh shifted = copy(ball);
  const mesh::Bounds bounds = mesh::measure_bounds(ball);
  const auto size = static_cast<float>(bounds.max.x - bounds.min.x);
  for (glm::vec3& p : shifted.positions) p += size * glm::vec3(0.23F, 0.17F, 0.11F);
  std::array<mesh::Mesh, 2> balls{copy(ball), std::move(shifted)};
  const mesh::Mesh both = std::move(*mesh::join_meshes(balls, Context()));
  const std::uint64_t before = count_pairs(both);
  ASSERT_GT(before, 50U);
  const SimplifiedMesh done = simplified_copy(both, to_count(both.triangles.size() / 10));
  EXPECT_LE(done.mesh.triangles.size(), both.triangles.size() / 10);
  EXPECT_LE(count_pairs(done.mesh), before);
}

// A ball, the same turned by half an edge, one that intersects both, and one far away.
mesh::Mesh overlaid_balls() {
  const mesh::Mesh ball = test::sphere(32, false);
  std::array<mesh::Mesh, 4> balls{copy(ball), copy(ball), copy(ball), copy(ball)};
  const glm::mat3 turned = glm::mat3({0.9988F, 0.0491F, 0}, {-0.0491F, 0.9988F, 0}, {0, 0, 1});
  for (glm::vec3& p : balls[1].positions) p = turned * p;
  for (glm::vec3& p : balls[2].positions) p += glm::vec3(0.46F, 0.34F, 0.22F);
  for (glm::vec3& p : balls[3].positions) p += glm::vec3(4.0F, 0.1F, 0.2F);
  return std::move(*mesh::join_meshes(balls, Context()));
}

TEST(SimplifyIntersections, AddsNoneToPlantedPairsWithoutGuard) {
  const mesh::Mesh balls = overlaid_balls();
  const std::uint64_t before = count_pairs(balls);
  ASSERT_GT(before, 5000U);
  SimplifyOptions options = to_distance(0.002);
  options.patch_size = 0.59;
  const auto guarded = static_cast<double>(simplified_copy(balls, options).mesh.triangles.size());
  for (const double patch_size : {0.7, 100.0}) {
    options.patch_size = patch_size;
    const SimplifiedMesh done = simplified_copy(balls, options);
    EXPECT_LE(count_pairs(done.mesh), before) << patch_size;
    EXPECT_LT(static_cast<double>(done.mesh.triangles.size()), 1.01 * guarded) << patch_size;
    EXPECT_GT(done.facts.untangled_collapses, 0U);
    EXPECT_LE(done.facts.distance_upper, options.max_distance);
  }
}

// One patch has the three balls that intersect, the other the ball far away.
TEST(UndoIntersections, UndoesWholePatchesWithManyPairs) {
  const mesh::Mesh balls = overlaid_balls();
  const auto triangles = static_cast<std::uint32_t>(balls.triangles.size());
  const std::uint32_t clean = triangles / 4 * 3;
  CollapseState state(balls.positions.span(), balls.positions.span(), balls.triangles.span());
  std::vector<std::uint32_t> all(triangles);
  std::iota(all.begin(), all.end(), 0U);
  const std::vector<char> locked(balls.positions.size(), 0);
  const std::vector<char> wanted(balls.positions.size(), 1);
  const CollapseLimits limits{.distance = 0.002, .proven = 0.002, .is_guarded = false};
  std::vector<CollapseLog> logs;
  logs.push_back(collapse_edges(state, std::span(all).first(clean), {locked, wanted}, limits, 0));
  logs.push_back(collapse_edges(state, std::span(all).subspan(clean), {locked, wanted}, limits, clean));
  ASSERT_GT(logs[0].removed, 1000U);
  ASSERT_GT(logs[1].removed, 300U);
  const auto undone = undo_intersections(state, logs, {}, SkippedPairs::none, "balls", Context());
  ASSERT_TRUE(undone);
  EXPECT_EQ(undone->patches, 1U);
  EXPECT_EQ(undone->collapses, logs[0].collapses.size());
  for (std::uint32_t t = 0; t < clean; ++t) {
    ASSERT_EQ(state.gone[t], 0);
    ASSERT_EQ(state.changed_by[t], kNone);
    ASSERT_EQ(state.corners[t], balls.triangles[t]);
  }
  EXPECT_EQ(std::ranges::count(state.gone, 1), static_cast<std::ptrdiff_t>(logs[1].removed));
  // Each triangle is listed once, though several collapses changed it.
  const auto same = std::ranges::adjacent_find(undone->restored, {}, &RestoredTriangle::triangle);
  EXPECT_EQ(same, undone->restored.end());
  EXPECT_GT(undone->restored.size(), logs[0].removed);
}

TEST(SimplifyIntersections, IsIndependentOfThreads) {
  const mesh::Mesh noisy = noisy_ball(32);
  SimplifyOptions without_guard = to_distance(0.05);
  without_guard.patch_size = 16;
  SimplifyOptions with_pairs = to_distance(0.002);
  with_pairs.patch_size = 0.7;
  const mesh::Mesh balls = overlaid_balls();
  const std::array<std::pair<const mesh::Mesh*, SimplifyOptions>, 3> cases{
      {{&noisy, to_count(noisy.triangles.size() / 6)}, {&noisy, without_guard}, {&balls, with_pairs}}};
  for (const auto& [mesh, options] : cases) {
    const auto simplified_by = [mesh = mesh, &options = options](std::size_t threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      return simplified_copy(*mesh, options).mesh;
    };
    const mesh::Mesh one = simplified_by(1);
    const mesh::Mesh several = simplified_by(4);
    EXPECT_TRUE(std::ranges::equal(one.triangles, several.triangles));
    EXPECT_TRUE(std::ranges::equal(one.positions, several.positions));
  }
}

TEST(SimplifyIntersections, RefusesNoCollapseOnCleanSurface) {
  const SimplifiedMesh done = simplified_copy(test::sphere(40, false), to_distance(0.1));
  EXPECT_EQ(done.facts.refused_collapses, 0U);
  EXPECT_EQ(done.facts.untangled_collapses, 0U);
}

TEST(SmoothIntersections, AddsNone) {
  const mesh::Mesh noisy = noisy_ball(40);
  ASSERT_EQ(count_pairs(noisy), 0U);
  for (const SmoothMethod method : {SmoothMethod::taubin, SmoothMethod::sinc, SmoothMethod::weighted}) {
    mesh::Mesh smoothed = copy(noisy);
    SmoothOptions options;
    options.method = method;
    const std::vector<float> weights(noisy.positions.size(), 1.0F);
    if (method == SmoothMethod::weighted) options.weights = weights;
    const auto facts = smooth(smoothed, options, Context());
    ASSERT_TRUE(facts);
    EXPECT_GT(facts->held_vertices, 0U);
    EXPECT_LT(facts->held_vertices, noisy.positions.size() / 3);
    EXPECT_EQ(count_pairs(smoothed), 0U) << static_cast<int>(method);
  }
  mesh::Mesh clean = test::sphere(40, false);
  EXPECT_EQ(smooth(clean, {}, Context())->held_vertices, 0U);
}

// A box of noise, whose samples along z from `tangled` on belong to a ball.
mesh::Mesh noise_and_ball(int size, int tangled) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> noise(-1, 1);
  const field::ScalarField field = test::dense_field<float>(glm::ivec3(size, size, 3 * size), [&](int i, int j, int k) {
    const bool inside = std::min({i, j, k}) > 0 && std::max(i, j) < size - 1 && k < tangled;
    if (inside) return noise(engine);
    return k < tangled ? -1.0 : size / 2.0 - 2 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(11.6, 11.4, 50.3));
  });
  return std::move(test::extract(field, {}).mesh);
}

// Noise whose caps close it at the sides of the data, which have the coordinates 0 and size - 1.
mesh::Mesh capped_noise(int size, std::uint32_t seed) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> noise(-1, 1);
  const field::ScalarField field =
      test::dense_field<float>(glm::ivec3(size), [&](int /*i*/, int /*j*/, int /*k*/) { return noise(engine); });
  extract::ExtractOptions options;
  options.cap = true;
  return std::move(test::extract(field, options).mesh);
}

mesh::Attribute numbers_of_vertices(const mesh::Mesh& mesh) {
  mesh::Attribute numbers{.name = "number", .type = mesh::ComponentType::u32, .values = {}};
  numbers.values = Buffer<std::byte>(mesh.positions.size() * sizeof(std::uint32_t));
  for (std::uint32_t v = 0; v < mesh.positions.size(); ++v) {
    std::memcpy(numbers.values.data() + v * sizeof v, &v, sizeof v);
  }
  return numbers;
}

std::size_t number_at(const mesh::Mesh& mesh, std::size_t vertex) {
  return static_cast<std::size_t>(
      mesh::component_value(mesh.attributes[0].at(vertex).data(), mesh::ComponentType::u32, false));
}

void expect_same_topology(const mesh::Mesh& before, const mesh::Mesh& after) {
  const mesh::Topology old = mesh::measure_topology(before);
  const mesh::Topology now = mesh::measure_topology(after);
  ASSERT_TRUE(old.is_closed_oriented_manifold());
  EXPECT_TRUE(now.is_closed_oriented_manifold());
  EXPECT_EQ(now.genus(), old.genus());
  EXPECT_EQ(now.components, old.components);
}

TEST(Untangle, ChangesNothingFarFromPairs) {
  constexpr int kTangled = 10;
  const mesh::Mesh tangled = noise_and_ball(24, kTangled);
  mesh::Mesh clean = copy(tangled);
  const auto figures = untangle(clean, {}, Context());
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->pairs_before, count_pairs(tangled));
  EXPECT_GT(figures->pairs_before, 20U);
  EXPECT_EQ(figures->pairs_after, 0U);
  EXPECT_EQ(count_pairs(clean), 0U);
  EXPECT_GT(figures->flips, 0U);
  expect_same_topology(tangled, clean);
  std::size_t moved = 0;
  ASSERT_EQ(clean.positions.size(), tangled.positions.size() + figures->splits);
  ASSERT_EQ(clean.triangles.size(), tangled.triangles.size() + 2 * figures->splits);
  for (std::size_t v = 0; v < tangled.positions.size(); ++v) {
    moved += clean.positions[v] != tangled.positions[v] ? 1 : 0;
  }
  EXPECT_EQ(moved, figures->moved);
  std::size_t in_ball = 0;
  for (std::size_t t = 0; t < tangled.triangles.size(); ++t) {
    const auto z = static_cast<float>(tangled.origin.z) + tangled.positions[tangled.triangles[t].x].z;
    if (z < 2 * kTangled) continue;
    ++in_ball;
    EXPECT_EQ(clean.triangles[t], tangled.triangles[t]);
  }
  EXPECT_GT(in_ball, 1000U);
}

TEST(Untangle, MovesVerticesAndSplitsEdgesIfFlipsFail) {
  constexpr int kSize = 16;
  std::uint64_t splits = 0;
  std::uint64_t moved = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    mesh::Mesh tangled = capped_noise(kSize, seed);
    tangled.origin = seed % 2 == 0 ? glm::dvec3(100, 200, 300) : glm::dvec3(0);
    mesh::Mesh clean = copy(tangled);
    clean.attributes.push_back(numbers_of_vertices(tangled));
    UntangleOptions options;
    options.walls = DataBox{.min = tangled.origin, .max = tangled.origin + glm::dvec3(kSize - 1)};
    const auto figures = untangle(clean, options, Context());
    ASSERT_TRUE(figures);
    EXPECT_GT(figures->pairs_before, 20U);
    EXPECT_EQ(count_pairs(clean), 0U) << seed;
    expect_same_topology(tangled, clean);
    EXPECT_LE(figures->greatest_move, 1);
    splits += figures->splits;
    moved += figures->moved;
    EXPECT_EQ(clean.positions.size(), tangled.positions.size() + figures->splits);
    for (std::size_t v = 0; v < tangled.positions.size(); ++v) {
      const glm::dvec3 old = tangled.position(v);
      for (int axis = 0; axis < 3; ++axis) {
        const double side = old[axis] - tangled.origin[axis];
        const bool is_on_side = side == 0 || side == kSize - 1;
        EXPECT_TRUE(!is_on_side || clean.position(v)[axis] == old[axis]);
      }
      EXPECT_EQ(number_at(clean, v), v);
    }
    for (std::size_t v = tangled.positions.size(); v < clean.positions.size(); ++v) {
      const std::size_t end = number_at(clean, v);
      ASSERT_LT(end, tangled.positions.size());
      EXPECT_LT(glm::length(clean.position(v) - tangled.position(end)), 3);
    }
  }
  EXPECT_GT(splits, 0U);
  EXPECT_GT(moved, 0U);
}

// Numbers of vertices as floats tell both ends of an edge: their mean is the value of its middle.
TEST(Untangle, NewVerticesHaveTheValuesOfTheMiddleOfTheirEdge) {
  constexpr int kSize = 16;
  std::uint64_t splits = 0;
  for (const std::uint32_t seed : {1U, 2U, 3U, 4U}) {
    mesh::Mesh clean = capped_noise(kSize, seed);
    clean.origin = seed % 2 == 0 ? glm::dvec3(100, 200, 300) : glm::dvec3(0);
    const std::size_t old = clean.positions.size();
    std::mt19937 engine(seed);
    std::uniform_real_distribution<float> coordinate(-1, 1);
    clean.normals = Buffer<glm::vec3>(old);
    for (glm::vec3& normal : clean.normals) {
      normal = glm::normalize(glm::vec3(coordinate(engine), coordinate(engine), 2));
    }
    clean.attributes.push_back(numbers_of_vertices(clean));
    mesh::Attribute floats{.name = "float", .type = mesh::ComponentType::f32, .values = {}};
    floats.values = Buffer<std::byte>(old * sizeof(float));
    for (std::size_t v = 0; v < old; ++v) {
      const auto number = static_cast<float>(v);
      std::memcpy(floats.values.data() + v * sizeof number, &number, sizeof number);
    }
    clean.attributes.push_back(std::move(floats));
    UntangleOptions options;
    options.walls = DataBox{.min = clean.origin, .max = clean.origin + glm::dvec3(kSize - 1)};
    const auto figures = untangle(clean, options, Context());
    ASSERT_TRUE(figures);
    splits += figures->splits;
    if (figures->splits == 0) continue;
    // The ends of the edge of the first new vertex are old vertices.
    const std::size_t from = number_at(clean, old);
    const double middle = mesh::component_value(clean.attributes[1].at(old).data(), mesh::ComponentType::f32, false);
    const auto to = static_cast<std::size_t>(2 * middle - static_cast<double>(from));
    ASSERT_NE(to, from);
    ASSERT_LT(to, old);
    EXPECT_LT(glm::length(clean.positions[to] - clean.positions[from]), 6);
    const glm::vec3 expected = glm::normalize(clean.normals[from] + clean.normals[to]);
    EXPECT_LT(glm::length(clean.normals[old] - expected), 1e-5F);
  }
  EXPECT_GT(splits, 0U);
}

TEST(Untangle, DoesNotDependOnThreads) {
  const mesh::Mesh tangled = capped_noise(16, 1);
  const auto untangled_by = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    mesh::Mesh clean = copy(tangled);
    EXPECT_TRUE(untangle(clean, {}, Context()));
    return clean;
  };
  const mesh::Mesh one = untangled_by(1);
  const mesh::Mesh several = untangled_by(4);
  EXPECT_TRUE(std::ranges::equal(one.triangles, several.triangles));
  EXPECT_TRUE(std::ranges::equal(one.positions, several.positions));
}

TEST(BoundSurfaceChange, MeasuresSpikesDentsAndNewTriangles) {
  const mesh::Mesh ball = test::sphere(20, false);
  const auto old_triangles = ball.triangles.span();
  EXPECT_EQ(*bound_surface_change(ball.positions.span(), old_triangles, ball, glm::dmat3(1.0), Context()), 0);
  mesh::Mesh spiked = copy(ball);
  spiked.positions[100] *= 1.25F;
  const double spike = *bound_surface_change(ball.positions.span(), old_triangles, spiked, glm::dmat3(2.0), Context());
  EXPECT_NEAR(spike, 2 * 0.25, 0.02);
  mesh::Mesh dented = copy(ball);
  dented.positions[100] *= 0.75F;
  const double dent = *bound_surface_change(ball.positions.span(), old_triangles, dented, glm::dmat3(1.0), Context());
  EXPECT_GT(dent, 0.15);
  EXPECT_LT(dent, 0.26);
  // An appended triangle counts, too.
  mesh::Mesh more = copy(ball);
  more.triangles = Buffer<glm::uvec3>(ball.triangles.size() + 1);
  std::ranges::copy(ball.triangles, more.triangles.begin());
  more.triangles[ball.triangles.size()] = ball.triangles[0];
  more.triangles[0] = {0, 10, 100};
  EXPECT_GT(*bound_surface_change(ball.positions.span(), old_triangles, more, glm::dmat3(1.0), Context()), 0.05);
}

}  // namespace
}  // namespace isoextract::edit

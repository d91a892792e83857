#include "edit/bounded_simplify.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "edit/detail/edge_collapse.hpp"
#include "field/demo_field.hpp"
#include "support/edge_collapses.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/simplify_promises.hpp"

namespace isoextract::edit {
namespace {

using test::expect_kept_promises;
using test::must_simplify;
using Case = test::SimplifyCase;

field::ScalarField demo(const std::string& name) { return *field::make_demo_field(name, Context()); }

TEST(BoundedSimplify, RemovesMostTrianglesOfSmoothSurfaces) {
  Case c;
  c.normals = true;
  c.max_distance = 0.1 * 2 / 47;  // the samples are on the cube from -1 to 1
  c.patch_size = 24.0 * 2 / 47;
  for (const extract::Method method : {extract::Method::mc, extract::Method::mt}) {
    c.method = method;
    EXPECT_LT(expect_kept_promises(demo("demo:sphere?size=48"), c), 0.2);
    EXPECT_LT(expect_kept_promises(demo("demo:torus?size=48"), c), 0.3);
  }
  c.max_distance = 0.1 * 2 / 31;
  c.patch_size = 24.0 * 2 / 31;
  EXPECT_LT(expect_kept_promises(demo("demo:gyroid?size=32"), c), 0.7);  // its tubes are a few voxels wide
}

TEST(BoundedSimplify, KeepsBoundaryLoopsWithinDistance) {
  Case c;
  c.cap = false;
  c.max_distance = 0.2 * 2 / 47;
  c.patch_size = 16.0 * 2 / 47;
  EXPECT_LT(expect_kept_promises(demo("demo:gyroid?size=48"), c), 0.6);
}

TEST(BoundedSimplify, KeepsPromisesOnNoiseAndCheckerboards) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    Case c;
    c.method = seed % 2 == 0 ? extract::Method::mc : extract::Method::mt;
    c.iso = 3.5;
    c.cap = seed % 4 < 3;
    c.max_distance = seed < 2 ? 0.1 : 1.0;
    expect_kept_promises(test::random_field<std::uint8_t>({14, 13, 12}, seed, 8), c);
    c.iso = 1;
    expect_kept_promises(test::random_field<std::uint8_t>({14, 13, 12}, seed, 3), c);
    c.iso = 0.5;
    expect_kept_promises(test::dense_field<float>({10, 11, 12}, [](int i, int j, int k) { return (i + j + k) % 2; }),
                         c);
  }
}

TEST(BoundedSimplify, KeepsThinShellsSpecksAndTubes) {
  for (const double distance : {0.05, 0.3, 2.0}) {
    Case c;
    c.iso = 0.5;
    c.max_distance = distance;
    // A shell one voxel thick: two spheres that must not be connected.
    const auto shell = test::dense_field<float>({24, 24, 24}, [](int i, int j, int k) {
      const double r = std::sqrt(std::pow(i - 11.5, 2) + std::pow(j - 11.5, 2) + std::pow(k - 11.5, 2));
      return std::max(0.0, 1 - std::abs(r - 8));
    });
    expect_kept_promises(shell, c);
    // Single voxels and tubes one voxel wide, which would collapse to nothing without the topology checks.
    const auto specks = test::dense_field<std::uint8_t>(
        {24, 24, 24}, [](int i, int j, int k) { return i % 4 == 1 && j % 4 == 1 && k % 4 == 1; });
    expect_kept_promises(specks, c);
    const auto tubes = test::dense_field<std::uint8_t>(
        {24, 24, 24}, [](int i, int j, int k) { return (i % 6 == 3) + (j % 6 == 3) + (k % 6 == 3) >= 2; });
    expect_kept_promises(tubes, c);
    const auto plate = test::dense_field<std::uint8_t>({24, 24, 24}, [](int i, int, int) { return i == 7; });
    expect_kept_promises(plate, c);
  }
}

TEST(BoundedSimplify, RemovesTrianglesOfFlatRegions) {
  const auto half = test::dense_field<float>({40, 40, 40}, [](int i, int, int) { return 19.3 - i; });
  Case c;
  c.max_distance = 0.01;
  c.patch_size = 24;
  EXPECT_LT(expect_kept_promises(half, c), 0.05);
}

// Its sides lie on planes of the grid, where a patch border would be visible.
TEST(BoundedSimplify, ReducesBoxesToTheirCorners) {
  const auto box = test::dense_field<float>({64, 64, 64}, [](int i, int j, int k) {
    return 25.0 - std::max({std::abs(i - 32.0), std::abs(j - 32.0), std::abs(k - 32.0)});
  });
  Case c;
  for (const double distance : {0.01, 0.1}) {
    c.max_distance = distance;
    EXPECT_LT(expect_kept_promises(box, c), 0.01);
  }
}

// Float values put vertices very close to the samples: the triangles are too thin to have a reliable normal.
TEST(BoundedSimplify, ReducesTiltedPlanesToTheirCorners) {
  const auto plane = test::dense_field<float>(
      {48, 48, 48}, [](int i, int j, int k) { return static_cast<float>(10.0 - (k - 0.3 * i - 0.17 * j)); });
  extract::ExtractOptions options;
  options.iso = 0;
  for (const double distance : {0.01, 0.1, 1.0}) {
    SimplifyOptions simplify;
    simplify.max_distance = distance;
    const auto [after, facts] = must_simplify(test::extract(plane, options).mesh, simplify);
    EXPECT_GT(facts.triangles_before, 4000U);
    EXPECT_LE(after.triangles.size(), 16U) << distance;
    EXPECT_LE(facts.distance_upper, distance);
  }
}

TEST(BoundedSimplify, NeverAddsTrianglesForLargerDistance) {
  const auto box = test::dense_field<float>({32, 32, 32}, [](int i, int j, int k) {
    return 11.0 - std::max({std::abs(i - 16.0), std::abs(j - 16.0), std::abs(k - 16.0)});
  });
  const auto tilted =
      test::dense_field<float>({40, 40, 40}, [](int i, int j, int k) { return 18.2 + 0.3 * i + 0.17 * j - k; });
  const auto ball = test::dense_field<float>({32, 32, 32}, [](int i, int j, int k) {
    return 12.3 - std::sqrt(std::pow(i - 16, 2) + std::pow(j - 16, 2) + std::pow(k - 16, 2));
  });
  const auto noise = test::random_field<std::uint8_t>({16, 16, 16}, 7, 8);
  const std::vector<std::pair<const field::ScalarField*, double>> inputs = {
      {&box, 0}, {&tilted, 0}, {&ball, 0}, {&noise, 3.5}};
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    extract::ExtractOptions options;
    options.iso = inputs[i].second;
    const mesh::Mesh mesh = test::extract(*inputs[i].first, options).mesh;
    std::size_t fewest = mesh.triangles.size();
    for (const double distance : {0.01, 0.03, 0.1, 0.3, 1.0, 2.0, 4.0}) {
      SimplifyOptions simplify;
      simplify.max_distance = distance;
      simplify.patch_size = 8;  // many patch outlines, where collapses of one patch block the next
      const std::size_t left = must_simplify(copy(mesh), simplify).mesh.triangles.size();
      EXPECT_LE(left, fewest) << "input " << i << " at " << distance;
      fewest = left;
    }
  }
}

// The percentage covers all rounds: it falls only where a stage begins.
TEST(BoundedSimplify, ReportsProgressOverAllRounds) {
  const mesh::Mesh before = test::sphere(64, false);
  SimplifyOptions options;
  options.max_distance = 0.5;
  options.patch_size = 4;
  const Context context;
  std::atomic<bool> ended = false;
  int falls = 0;
  std::thread watcher([&] {
    for (std::uint64_t last = 0; !ended;) {
      const std::uint64_t now = context.progress().done();
      if (now < last) ++falls;
      last = now;
    }
  });
  const auto done = simplify_mesh(copy(before), options, context);
  ended = true;
  watcher.join();
  ASSERT_TRUE(done);
  EXPECT_GT(done->facts.rounds, 2);
  EXPECT_LE(falls, done->facts.passes + 1);
}

TEST(BoundedSimplify, WorksInAnisotropicObliqueMirroredAndFarFrames) {
  for (const glm::dvec3 far : {glm::dvec3(0), glm::dvec3(1e7, -1e7, 1e7)}) {
    field::ScalarField field = demo("demo:torus?size=40");
    field.index_to_world = {glm::dmat3(-0.5, 0.1, 0, 0.2, 3, 0, 0, 0.7, 20), far};
    Case c;
    c.max_distance = 0.1;
    c.to_metric = glm::inverse(field.index_to_world.linear);
    c.patch_size = 12;
    EXPECT_LT(expect_kept_promises(field, c), 0.6);
  }
}

TEST(BoundedSimplify, IsIndependentOfThreads) {
  extract::ExtractOptions options;
  options.cap = true;
  const mesh::Mesh mesh = test::extract(demo("demo:gyroid?size=40"), options).mesh;
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SimplifyOptions simplify;
    simplify.max_distance = 0.1;
    simplify.patch_size = 8;
    return must_simplify(copy(mesh), simplify);
  };
  const SimplifiedMesh one = with_threads(1);
  const SimplifiedMesh four = with_threads(4);
  ASSERT_EQ(one.mesh.triangles.size(), four.mesh.triangles.size());
  EXPECT_EQ(std::memcmp(one.mesh.triangles.data(), four.mesh.triangles.data(), one.mesh.triangles.size_bytes()), 0);
  EXPECT_EQ(std::memcmp(one.mesh.positions.data(), four.mesh.positions.data(), one.mesh.positions.size_bytes()), 0);
  EXPECT_EQ(one.facts.distance_upper, four.facts.distance_upper);
  EXPECT_EQ(one.facts.distance_lower, four.facts.distance_lower);
}

TEST(BoundedSimplify, ReturnsMeshIfNothingCanCollapse) {
  SimplifyOptions options;
  options.max_distance = 1e-3;
  const auto [empty, none] = must_simplify(mesh::Mesh{}, options);
  EXPECT_TRUE(empty.triangles.empty());
  EXPECT_EQ(none.distance_upper, 0);
  const auto [same, facts] = must_simplify(test::tetrahedron(), options);
  EXPECT_EQ(same.triangles.size(), 4U);
  EXPECT_EQ(facts.distance_upper, 0);
}

TEST(BoundedSimplify, ObeysCancellationAndMemoryBudget) {
  SimplifyOptions options;
  options.max_distance = 0.05;
  const Context small{MemoryBudget(100000)};
  const auto refused = simplify_mesh(test::sphere(40, true), options, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_EQ(small.memory().reserved(), 0U);
  const Context cancelled;
  cancelled.cancel();
  const auto ended = simplify_mesh(test::sphere(40, true), options, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
  // Memory that the smaller mesh does not need is released.
  const Context context;
  mesh::Mesh mesh = test::sphere(40, true);
  mesh.memory = std::move(*context.reserve(1 << 20, "test"));
  const auto done = simplify_mesh(std::move(mesh), options, context);
  ASSERT_TRUE(done);
  EXPECT_EQ(context.memory().reserved(), done->mesh.memory.bytes());
  EXPECT_EQ(done->mesh.memory.bytes(),
            done->mesh.positions.size() * 2 * sizeof(glm::vec3) + done->mesh.triangles.size_bytes());
}

TEST(BoundedSimplify, KeepsVertexAttributes) {
  mesh::Mesh before = test::sphere(40, true);
  test::add_color(before, mesh::ComponentType::u8, 3);
  SimplifyOptions options;
  options.max_distance = 0.05;
  const mesh::Mesh after = must_simplify(copy(before), options).mesh;
  ASSERT_LT(after.positions.size(), before.positions.size());
  for (std::size_t v = 0; v < after.positions.size(); ++v) {
    const auto* found = std::ranges::find(before.positions, after.positions[v]);
    const auto was = static_cast<std::size_t>(found - before.positions.begin());
    ASSERT_LT(was, before.positions.size());
    EXPECT_EQ(after.normals[v], before.normals[was]);
    EXPECT_TRUE(std::ranges::equal(after.attributes[0].at(v), before.attributes[0].at(was)));
  }
}

// Collapses edges of all triangles as one patch. Returns the remaining triangles.
mesh::Mesh collapsed(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles,
                     const std::vector<char>& locked, double distance) {
  CollapseState state(positions, positions, triangles);
  const auto left = test::collapse_and_undo(state, locked, distance);
  return test::make_mesh("collapsed", positions, left);
}

// Without the link condition, a thin closed tube becomes two triangles back to back.
TEST(EdgeCollapse, KeepsTubesClosed) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  constexpr unsigned kRings = 20;
  for (unsigned r = 0; r < kRings; ++r) {
    for (unsigned c = 0; c < 3; ++c) {
      const double angle = 2.0943951 * c;
      positions.emplace_back(0.01 * std::cos(angle), 0.01 * std::sin(angle), r);
    }
  }
  for (unsigned r = 0; r + 1 < kRings; ++r) {
    for (unsigned c = 0; c < 3; ++c) {
      const unsigned a = 3 * r + c;
      const unsigned b = 3 * r + (c + 1) % 3;
      triangles.insert(triangles.end(), {{a, b, b + 3}, {a, b + 3, a + 3}});
    }
  }
  const unsigned last = 3 * (kRings - 1);
  triangles.insert(triangles.end(), {{0, 2, 1}, {last, last + 1, last + 2}});
  const std::vector<char> none(positions.size(), 0);
  for (const double distance : {1e-4, 1e-2, 0.1, 1.0, 100.0}) {
    const mesh::Mesh left = collapsed(positions, triangles, none, distance);
    const mesh::Topology topology = mesh::measure_topology(left);
    EXPECT_TRUE(topology.is_closed_oriented_manifold()) << distance;
    EXPECT_EQ(topology.euler, 2) << distance;
    EXPECT_GE(left.triangles.size(), 4U) << distance;
  }
}

// A tetrahedron with three triangles in one patch and one in another must not become two mirrored triangles.
TEST(EdgeCollapse, KeepsTetrahedraBetweenPatches) {
  const std::vector<glm::vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3F, 0.3F, 0.05F}};
  const std::vector<glm::uvec3> triangles{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
  CollapseState state(positions, positions, triangles);
  const std::vector<std::uint32_t> patch{0, 1, 2};
  const std::vector<char> locked{1, 1, 1, 0};
  const std::vector<char> wanted(4, 1);
  EXPECT_EQ(collapse_edges(state, patch, {locked, wanted}, CollapseLimits(), 0).collapses.size(), 0U);
}

TEST(EdgeCollapse, KeepsLockedVerticesAndCollapsesStraightBoundaries) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  constexpr unsigned kSide = 20;
  for (unsigned j = 0; j <= kSide; ++j) {
    for (unsigned i = 0; i <= kSide; ++i) positions.emplace_back(i, j, 0);
  }
  std::vector<char> on_boundary(positions.size(), 0);
  for (unsigned v = 0; v < positions.size(); ++v) {
    const unsigned i = v % (kSide + 1);
    const unsigned j = v / (kSide + 1);
    on_boundary[v] = i == 0 || j == 0 || i == kSide || j == kSide ? 1 : 0;
  }
  for (unsigned j = 0; j < kSide; ++j) {
    for (unsigned i = 0; i < kSide; ++i) {
      const unsigned v = j * (kSide + 1) + i;
      triangles.insert(triangles.end(), {{v, v + 1, v + kSide + 2}, {v, v + kSide + 2, v + kSide + 1}});
    }
  }
  for (const bool locked : {true, false}) {
    const mesh::Mesh flat =
        collapsed(positions, triangles, locked ? on_boundary : std::vector<char>(positions.size(), 0), 0.01);
    const mesh::Topology topology = mesh::measure_topology(flat);
    EXPECT_LT(flat.triangles.size(), locked ? triangles.size() / 4 : 9);
    if (locked) {
      EXPECT_EQ(topology.open_edges, 4U * kSide);
    }
    EXPECT_EQ(topology.euler, 1);
    EXPECT_EQ(mesh::measure_size(flat).zero_area_triangles, 0U);
    EXPECT_NEAR(mesh::measure_size(flat).area, kSide * kSide, 1e-9);
  }
}

}  // namespace
}  // namespace isoextract::edit

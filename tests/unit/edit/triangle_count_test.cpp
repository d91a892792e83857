#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "accuracy/mesh_distance.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/detail/collapse_state.hpp"
#include "edit/detail/edge_collapse.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::edit {
namespace {

SimplifiedMesh simplified_to(const mesh::Mesh& mesh, const SimplifyOptions& options) {
  auto simplified = simplify_mesh(copy(mesh), options, Context());
  if (!simplified) throw std::runtime_error(simplified.error().message);
  return std::move(*simplified);
}

void expect_measured(const mesh::Mesh& before, const SimplifiedMesh& simplified) {
  const auto distance = accuracy::measure_distance(before, simplified.mesh, accuracy::DistanceOptions(), Context());
  EXPECT_LE(distance->hausdorff_lower, simplified.facts.distance_upper + distance->resolution);
  EXPECT_LE(simplified.facts.distance_lower, distance->hausdorff_upper + distance->resolution);
}

TEST(SimplifyToCount, ReachesTriangleCount) {
  const mesh::Mesh before = test::sphere(40, false);
  for (const std::size_t asked : {before.triangles.size() / 2, before.triangles.size() / 10, std::size_t{100}}) {
    SimplifyOptions options;
    options.max_distance = std::numeric_limits<double>::infinity();
    options.triangles = asked;
    options.patch_size = 8;
    const SimplifiedMesh done = simplified_to(before, options);
    const auto& [after, facts] = done;
    EXPECT_LE(after.triangles.size(), asked);
    EXPECT_GE(after.triangles.size() + 2, asked);
    test::expect_sound(after, true);
    expect_measured(before, done);
    EXPECT_LE(facts.distance_upper, 1.03 * facts.distance_lower);
  }
}

// Uses patches on a surface with a boundary loop and handles, with several numbers of threads.
TEST(SimplifyToCount, ReachesTriangleCountInPatches) {
  extract::ExtractOptions extract;
  extract.output_from_index = {glm::dmat3(1.0), {}};
  const mesh::Mesh before = test::extract(*field::make_demo_field("demo:gyroid?size=40", Context()), extract).mesh;
  const mesh::Topology was = mesh::measure_topology(before);
  ASSERT_GT(was.open_edges, 0U);
  for (const double most : {std::numeric_limits<double>::infinity(), 0.3}) {
    SimplifyOptions options;
    options.max_distance = most;
    options.triangles = before.triangles.size() / 8;
    options.patch_size = 6;
    const SimplifiedMesh done = simplified_to(before, options);
    const auto& [after, facts] = done;
    EXPECT_GT(facts.patches, 100U);
    EXPECT_GT(facts.rounds, 2);
    EXPECT_GE(after.triangles.size() + 2, options.triangles);
    if (std::isinf(most)) {
      EXPECT_LE(after.triangles.size(), options.triangles);
    } else {
      EXPECT_LE(facts.distance_upper, most);
      EXPECT_LT(after.triangles.size(), before.triangles.size() / 2);
    }
    const mesh::Topology is = mesh::measure_topology(after);
    test::expect_sound(after, false);
    EXPECT_EQ(is.components, was.components);
    EXPECT_EQ(is.euler, was.euler);
    expect_measured(before, done);
    const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
    const auto alone = simplified_to(before, options);
    ASSERT_EQ(alone.mesh.triangles.size(), after.triangles.size());
    EXPECT_EQ(std::memcmp(alone.mesh.triangles.data(), after.triangles.data(), after.triangles.size_bytes()), 0);
    EXPECT_EQ(alone.facts.distance_upper, facts.distance_upper);
  }
}

// Blocks of a few voxels on a plane. Samples underestimate the distance there, so collapses are undone and replaced.
TEST(SimplifyToCount, ReplacesUndoneCollapses) {
  constexpr int kSide = 96;
  std::mt19937 random(8);
  std::vector<float> height(kSide * kSide, 0.0F);
  for (int block = 0; block < 120; ++block) {
    const int width = 1 + static_cast<int>(random() % 3);
    const int x = 4 + static_cast<int>(random() % (kSide - 10));
    const int y = 4 + static_cast<int>(random() % (kSide - 10));
    const float high = 9.0F * static_cast<float>(random()) / 4294967296.0F;
    for (int k = 0; k < width * width; ++k) height[(y + k / width) * kSide + x + k % width] = high;
  }
  extract::ExtractOptions extract;
  const auto field = test::dense_field<float>(
      {kSide, kSide, 20}, [&](int i, int j, int k) { return height[j * kSide + i] - (static_cast<float>(k) - 3.7F); });
  const mesh::Mesh before = test::extract(field, extract).mesh;
  std::uint64_t undone_collapses = 0;
  for (const int percent : {6, 8, 10}) {
    SimplifyOptions options;
    options.max_distance = std::numeric_limits<double>::infinity();
    options.triangles = before.triangles.size() * static_cast<std::size_t>(percent) / 100;
    const SimplifiedMesh done = simplified_to(before, options);
    const auto& [after, facts] = done;
    undone_collapses += facts.undone_collapses;

    test::expect_sound(after, false);
    expect_measured(before, done);
  }
  EXPECT_GT(undone_collapses, 0U);
}

// A vertex that an undo restored must not be in a sample list: the next collapse would list it twice.
TEST(SimplifyToCount, DropsSamplesOfRestoredVertices) {
  const mesh::Mesh mesh = test::sphere(16, false);
  CollapseState state(mesh.positions.span(), mesh.positions.span(), mesh.triangles.span());
  std::vector<std::uint32_t> patch(mesh.triangles.size());
  std::iota(patch.begin(), patch.end(), 0U);
  const std::vector<char> locked(mesh.positions.size(), 0);
  const std::vector<char> wanted(mesh.positions.size(), 1);
  const std::vector<CollapseLog> logs{collapse_edges(state, patch, {locked, wanted}, {.triangles = 100}, 0)};
  const auto collapses = static_cast<std::uint32_t>(logs[0].collapses.size());
  ASSERT_GT(collapses, 100U);
  std::vector<RestoredTriangle> changed;
  undo_collapse(collapses / 2, state, logs, changed);
  drop_restored_samples(state);

  std::vector<int> held(mesh.positions.size(), 0);
  for (std::uint32_t sample : state.first_sample) {
    for (; sample != kNone && held[sample] < 2; sample = state.next_sample[sample]) ++held[sample];
  }
  std::size_t gone = 0;
  std::vector<char> there(mesh.positions.size(), 0);
  for (std::size_t t = 0; t < state.corners.size(); ++t) {
    if (state.gone[t] != 0) continue;
    for (int corner = 0; corner < 3; ++corner) there[state.corners[t][corner]] = 1;
  }
  for (std::size_t v = 0; v < held.size(); ++v) {
    EXPECT_LE(held[v], there[v] != 0 ? 0 : 1) << v;
    gone += there[v] == 0 ? 1 : 0;
  }
  EXPECT_GT(gone, 100U);
}

// Isolated specks become one triangle each, in more patches than any number of rounds could merge.
TEST(SimplifyToCount, EndsIfTopologyBlocksCollapses) {
  extract::ExtractOptions extract;
  extract.iso = 0.5;
  const auto field = test::dense_field<std::uint8_t>(
      {80, 80, 40}, [](int i, int j, int k) { return i % 8 == 0 && j % 8 == 0 && k % 8 == 0 ? 1 : 0; });
  const mesh::Mesh before = test::extract(field, extract).mesh;
  for (const double distance : {std::numeric_limits<double>::infinity(), 3.0}) {
    SimplifyOptions options;
    options.max_distance = distance;
    options.triangles = 10;
    options.patch_size = 8;
    const SimplifiedMesh done = simplified_to(before, options);
    const auto& [after, facts] = done;
    EXPECT_LT(facts.rounds, 40);
    EXPECT_EQ(mesh::measure_topology(after).components, mesh::measure_topology(before).components);
  }
}

}  // namespace
}  // namespace isoextract::edit

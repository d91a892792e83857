// Surface nets of label maps: closed and manifold for any labels, smooth, and without gaps between labels.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <set>

#include "support/voxel_patterns.hpp"
#include "unit/extract/label_nets.hpp"

namespace isoextract::extract {
namespace {

using PlacedTriangle = std::array<test::Point, 3>;

PlacedTriangle turned_over(PlacedTriangle triangle) {
  std::swap(triangle[1], triangle[2]);
  return triangle;
}

// Returns the number of triangles of all meshes whose reverse is in no other mesh, and calls alone(triangle) for each.
// These are triangles next to voxels without a label. Expects that no triangle occurs twice.
template <class Alone>
std::size_t triangles_alone(const Labels& meshes, const Alone& found) {
  std::multiset<PlacedTriangle> all;
  for (const auto& [label, mesh] : meshes) {
    for (const PlacedTriangle& triangle : test::triangle_set(mesh)) all.insert(triangle);
  }
  std::size_t alone = 0;
  for (const PlacedTriangle& triangle : all) {
    EXPECT_EQ(all.count(triangle), 1U);
    if (all.count(turned_over(triangle)) != 0) continue;
    ++alone;
    found(triangle);
  }
  return alone;
}

// If all samples have a label, triangles in one mesh only lie in the flat data boundary.
void expect_no_gaps(const Labels& meshes, const glm::ivec3& dims) {
  const auto in_data_boundary = [&](const PlacedTriangle& triangle) {
    const auto lies_in = [&](auto coordinate, int count) {
      return std::ranges::all_of(triangle, [&](const test::Point& p) { return coordinate(p) == -0.5; }) ||
             std::ranges::all_of(triangle, [&](const test::Point& p) { return coordinate(p) == count - 0.5; });
    };
    return lies_in([](const test::Point& p) { return std::get<0>(p); }, dims.x) ||
           lies_in([](const test::Point& p) { return std::get<1>(p); }, dims.y) ||
           lies_in([](const test::Point& p) { return std::get<2>(p); }, dims.z);
  };
  const std::size_t alone = triangles_alone(
      meshes, [&](const PlacedTriangle& triangle) { EXPECT_TRUE(in_data_boundary(triangle)) << "a gap"; });
  EXPECT_GE(alone, static_cast<std::size_t>(4 * (dims.x * dims.y + dims.y * dims.z + dims.z * dims.x)));
}

// The number of voxel faces with no label on one side, and of faces with a label on each side.
std::pair<std::int64_t, std::int64_t> count_faces(const glm::ivec3& dims, const auto& label) {
  std::int64_t outer = 0;
  std::int64_t inner = 0;
  const auto at = [&](const glm::ivec3& p) {
    const bool there = glm::all(glm::greaterThanEqual(p, glm::ivec3(0))) && glm::all(glm::lessThan(p, dims));
    return there ? static_cast<int>(label(p.x, p.y, p.z)) : 0;
  };
  for (int z = -1; z <= dims.z; ++z) {
    for (int y = -1; y <= dims.y; ++y) {
      for (int x = -1; x <= dims.x; ++x) {
        for (int axis = 0; axis < 3; ++axis) {
          glm::ivec3 next(x, y, z);
          ++next[axis];
          const int a = at({x, y, z});
          const int b = at(next);
          if (a == b) continue;
          (a == 0 || b == 0 ? outer : inner)++;
        }
      }
    }
  }
  return {outer, inner};
}

void expect_right(const Labels& meshes) {
  for (const auto& [label, mesh] : meshes) {
    SCOPED_TRACE(label);
    test::expect_sound(mesh, true);
    for (const glm::vec3& p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
  }
}

// All 3^8 patterns of three labels; the first one is no label in one round and a label in the other.
TEST(LabelNets, MeshesAllPatternsOfEightVoxels) {
  for (unsigned pattern = 1; pattern < 6561; ++pattern) {
    SCOPED_TRACE(pattern);
    std::array<int, 8> labels{};
    unsigned rest = pattern;
    for (int& label : labels) {
      label = static_cast<int>(rest % 3);
      rest /= 3;
    }
    for (const int first : {0, 1}) {
      const field::ScalarField field = test::dense_field<std::uint8_t>(
          {2, 2, 2}, [&](int x, int y, int z) { return first + labels[static_cast<std::size_t>(x + 2 * y + 4 * z)]; });
      const Labels meshes = nets_of(field);
      expect_right(meshes);
      if (first == 1) expect_no_gaps(meshes, {2, 2, 2});
    }
    if (testing::Test::HasFailure()) return;
  }
}

TEST(LabelNets, ClosesRandomLabelsWithoutGaps) {
  for (unsigned seed = 0; seed < 400; ++seed) {
    SCOPED_TRACE(seed);
    const glm::ivec3 dims{2 + static_cast<int>(seed % 5), 3 + static_cast<int>(seed / 5 % 4), 4};
    std::mt19937 engine(seed);
    const int first = static_cast<int>(seed % 2);
    const unsigned count = 2 + seed / 20 % 5;
    const field::ScalarField field = test::dense_field<std::int16_t>(
        dims, [&](int, int, int) { return first + static_cast<int>(engine() % count); });
    for (const std::uint64_t rounds : {0U, 3U}) {
      const Labels meshes = nets_of(field, net_options(rounds));
      expect_right(meshes);
      if (first == 1) expect_no_gaps(meshes, dims);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Across chunks; the number of triangles at chunk faces is that of the faces.
TEST(LabelNets, SharesEveryFaceBetweenBothLabels) {
  const glm::ivec3 dims{70, 17, 19};
  // Balls, because labels that touch themselves along an edge have more triangles.
  const auto label = [](int x, int y, int z) {
    const glm::dvec3 p(x, y, z);
    if (glm::distance(p, glm::dvec3(60.3, 8.1, 9.2)) < 6) return 3;
    if (x < 5) return 1;
    return x < 40 ? 2 : 0;
  };
  const field::ScalarField field = test::dense_field<std::int32_t>(dims, label);
  const Labels meshes = nets_of(field);
  expect_right(meshes);
  const auto [outer, inner] = count_faces(dims, label);
  std::size_t triangles = 0;
  for (const auto& [number, mesh] : meshes) triangles += mesh.triangles.size();
  EXPECT_EQ(triangles, static_cast<std::size_t>(2 * outer + 4 * inner));
  EXPECT_EQ(triangles_alone(meshes, [](const PlacedTriangle&) {}), static_cast<std::size_t>(2 * outer));
}

field::ScalarField ball_of_halves(int radius, bool halves) {
  const int side = 2 * radius + 6;
  return test::dense_field<std::uint8_t>(glm::ivec3(side), [&](int x, int y, int z) {
    const glm::dvec3 p = glm::dvec3(x, y, z) - (side - 1) / 2.0 + 0.137;
    if (glm::dot(p, p) >= radius * radius) return 0;
    return halves && p.x > 0 ? 2 : 1;
  });
}

// Returns the mean angle in degrees between the normals of triangles with a common edge.
double mean_angle_of_neighbors(const mesh::Mesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, glm::dvec3> normals;  // of the triangle at each directed edge
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]);
    const glm::dvec3 normal =
        glm::normalize(glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a));
    for (int c = 0; c < 3; ++c) normals[{t[c], t[(c + 1) % 3]}] = normal;
  }
  double sum = 0;
  for (const auto& [edge, normal] : normals) {
    sum += std::acos(std::clamp(glm::dot(normal, normals.at({edge.second, edge.first})), -1.0, 1.0));
  }
  return sum / static_cast<double>(normals.size()) * 180 / std::numbers::pi;
}

TEST(LabelNets, KeepsAreaAndVolumeOfBalls) {
  for (const int radius : {10, 20, 40}) {
    SCOPED_TRACE(radius);
    const Labels meshes = nets_of(ball_of_halves(radius, false));
    const auto size = mesh::measure_size(meshes.at(1));
    const double area = 4 * std::numbers::pi * radius * radius;
    EXPECT_NEAR(size.area / area, 1, 0.005);  // the faces of voxels have 1.5 times that area, for any radius
    EXPECT_NEAR(size.volume / (area * radius / 3), 1, 0.003);
    EXPECT_LT(mean_angle_of_neighbors(meshes.at(1)), 36.0 / radius + 0.8);  // 36 / radius: on a smooth ball
    const Labels steps = nets_of(ball_of_halves(radius, false), net_options(0));
    EXPECT_GT(mesh::measure_size(steps.at(1)).area / area, 1.45);
  }
}

// The plane between the halves is flat and does not move, and its rim is a circle.
TEST(LabelNets, KeepsCurvesWhereThreeLabelsMeet) {
  constexpr int kRadius = 20;
  const Labels meshes = nets_of(ball_of_halves(kRadius, true));
  const double middle = (2 * kRadius + 5) / 2.0 - 0.137;
  std::set<PlacedTriangle> other;
  for (const PlacedTriangle& t : test::triangle_set(meshes.at(2))) other.insert(turned_over(t));
  double plane = 0;
  double far = 0;
  for (const PlacedTriangle& t : test::triangle_set(meshes.at(1))) {
    if (!other.contains(t)) continue;
    std::array<glm::dvec3, 3> p{};
    for (std::size_t c = 0; c < 3; ++c) {
      p[c] = {std::get<0>(t[c]), std::get<1>(t[c]), std::get<2>(t[c])};
      EXPECT_NEAR(p[c].x, middle, 0.5);
      far = std::max(far, std::hypot(p[c].y - middle, p[c].z - middle));
    }
    plane += glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) / 2;
  }
  EXPECT_NEAR(plane / (std::numbers::pi * kRadius * kRadius), 1, 0.02);
  EXPECT_NEAR(far, kRadius, 0.6);
}

// A cube of two labels in the corner of the data: its faces in the data boundary are flat up to their edges.
TEST(LabelNets, KeepsDataBoundaryFlat) {
  const field::ScalarField field =
      test::dense_field<std::uint8_t>({9, 8, 7}, [](int x, int y, int z) { return x + y + z < 10 ? 1 : 2; });
  const Labels meshes = nets_of(field);
  expect_right(meshes);
  double volume = 0;
  for (const auto& [label, mesh] : meshes) volume += mesh::measure_size(mesh).volume;
  EXPECT_NEAR(volume, 9 * 8 * 7, 1e-3);
  const mesh::Bounds bounds = mesh::measure_bounds(meshes.at(1));
  EXPECT_EQ(bounds.min, glm::dvec3(-0.5));
}

TEST(LabelNets, KeepsVerticesWithinCells) {
  const field::ScalarField field = test::random_field<std::uint8_t>({30, 20, 20}, 3, 4);
  const Labels moved = nets_of(field, net_options(50));
  const Labels still = nets_of(field, net_options(0));
  for (const auto& [label, mesh] : moved) {
    const mesh::Mesh& before = still.at(label);
    ASSERT_EQ(mesh.positions.size(), before.positions.size());
    float farthest = 0;
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const glm::vec3 way = glm::abs(mesh.positions[v] - before.positions[v]);
      farthest = std::max({farthest, way.x, way.y, way.z});
    }
    EXPECT_LT(farthest, 0.5F);
    EXPECT_GT(farthest, 0.3F);
  }
}

void expect_same(const Labels& a, const Labels& b) {
  for (const auto& [label, mesh] : a) {
    const mesh::Mesh& other = b.at(label);
    EXPECT_TRUE(
        std::equal(mesh.positions.begin(), mesh.positions.end(), other.positions.begin(), other.positions.end()));
    EXPECT_TRUE(
        std::equal(mesh.triangles.begin(), mesh.triangles.end(), other.triangles.begin(), other.triangles.end()));
  }
}

TEST(LabelNets, MakesTheSameMeshesForChosenLabels) {
  const field::ScalarField field = test::random_field<std::uint16_t>({20, 20, 20}, 7, 5);
  const Labels some = nets_of(field, net_options(), {false, {4, 2}});
  EXPECT_EQ(some.size(), 2U);
  expect_same(some, nets_of(field));
}

TEST(LabelNets, IsIndependentOfThreads) {
  const field::ScalarField field = test::random_field<std::uint8_t>({150, 40, 30}, 8, 4);
  Labels first;
  for (const std::size_t threads : {1, 2, 7}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    Labels meshes = nets_of(field);
    if (threads == 1)
      first = std::move(meshes);
    else
      expect_same(first, meshes);
  }
}

// Blocks, tiles and a background with any labels.
TEST(LabelNets, SparseEqualsDense) {
  const auto label = [](int x, int y, int z) {
    if (x < 16 || y < 8 || z < 8 || x >= 80 || y >= 24 || z >= 24) return 0;
    return x < 40 ? 3 : glm::distance(glm::dvec3(x, y, z), glm::dvec3(60.2, 16.3, 15.1)) < 7 ? 5 : 0;
  };
  const field::ScalarField dense = test::dense_field<std::int32_t>({96, 32, 32}, label);
  const Labels of_dense = nets_of(dense);
  const Labels of_sparse = nets_of(test::sparse_copy<std::int32_t>(dense, 0));
  ASSERT_EQ(of_dense.size(), 2U);
  ASSERT_EQ(of_sparse.size(), 2U);
  for (const auto& [number, mesh] : of_dense) {
    test::expect_sound(of_sparse.at(number), true);
    EXPECT_EQ(test::triangle_set(mesh), test::triangle_set(of_sparse.at(number)));
  }
}

// A tile's voxels count although most of its chunks are stored nowhere.
TEST(LabelNets, CountsVoxelsOfTiles) {
  field::SparseSamples samples;
  samples.type = field::SampleType::u16;
  samples.tiles = {{{0, 0, 0}, 256, 3}, {{256, 0, 0}, 8, 3}, {{256, 8, 0}, 8, 4}};
  samples.active_box = {{0, 0, 0}, {263, 255, 255}};
  field::ScalarField field;
  field.source = "tiles";
  field.samples = samples;
  ExtractOptions options = net_options(0);
  const auto all = LabelVoxels::find(field, options, {true, {}}, Context());
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->labels(), (std::vector<std::int64_t>{3, 4}));
  EXPECT_EQ(all->find(3)->voxels, 256U * 256 * 256 + 512);
  EXPECT_EQ(all->find(3)->bounds, (field::IndexBox{{0, 0, 0}, {263, 255, 255}}));
  EXPECT_EQ(all->find(4)->voxels, 512U);
  options.region = field::IndexBox{{10, 20, 30}, {259, 12 + 20, 31}};
  const auto part = LabelVoxels::find(field, options, {true, {}}, Context());
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(part->find(3)->voxels, 246U * 13 * 2);
  EXPECT_EQ(part->find(3)->bounds, (field::IndexBox{{10, 20, 30}, {255, 32, 31}}));
}

TEST(LabelNets, ReadsEveryIntegerType) {
  const auto label = [](int x, int y, int z) { return (x + y) / 4 + (z > 3 ? 2 : 0); };
  const auto expected = nets_of(test::dense_field<std::uint8_t>({9, 9, 9}, label));
  const auto check = [&](const field::ScalarField& field) { expect_same(expected, nets_of(field)); };
  check(test::dense_field<std::int8_t>({9, 9, 9}, label));
  check(test::dense_field<std::int16_t>({9, 9, 9}, label));
  check(test::dense_field<std::uint16_t>({9, 9, 9}, label));
  check(test::dense_field<std::int32_t>({9, 9, 9}, label));
  check(test::dense_field<std::uint32_t>({9, 9, 9}, label));
}

TEST(LabelNets, MakesTwoLabelsFromAnIsoValue) {
  const field::ScalarField field = ball_of_halves(12, false);
  ExtractOptions options = net_options();
  options.iso = 0.5;
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  test::expect_sound(mesh, true);
  EXPECT_EQ(test::triangle_set(mesh), test::triangle_set(nets_of(field).at(1)));
  options.region = field::IndexBox{{0, 0, 0}, {14, 29, 29}};
  const mesh::Mesh part = test::extract(field, options).mesh;
  test::expect_sound(part, true);
  EXPECT_EQ(mesh::measure_bounds(part).max.x, 14.5);
}

TEST(LabelNets, KeepsWindingForMirrorsAndShears) {
  const field::ScalarField field =
      test::dense_field<std::uint8_t>({9, 8, 7}, [](int x, int y, int z) { return 1 + (x * 5 + y * 3 + z) % 7 / 3; });
  for (const double sign : {1.0, -1.0}) {
    ExtractOptions options = net_options();
    options.output_from_index.linear = {{0.5 * sign, 0, 0}, {0.25, 2, 0}, {0, -1, 4}};
    const Labels meshes = nets_of(field, options);
    for (const auto& [label, mesh] : meshes) {
      test::expect_sound(mesh, true);
      EXPECT_GT(mesh::measure_size(mesh).volume, 0);
    }
    // The volumes of labels that share their boundaries add up.
    double volume = 0;
    for (const auto& [label, mesh] : meshes) volume += mesh::measure_size(mesh).volume;
    EXPECT_NEAR(volume, 4.0 * 9 * 8 * 7, 0.01);
  }
}

TEST(LabelNets, ReservesMemoryAndStopsWhenCancelled) {
  const field::ScalarField field = test::random_field<std::uint8_t>({64, 64, 64}, 1, 4);
  const Context small{MemoryBudget(1 << 20)};
  const auto refused = LabelVoxels::find(field, net_options(), {true, {}}, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(small.memory().reserved(), 0U);
  Context enough{MemoryBudget(1 << 28)};
  {
    const auto found = LabelVoxels::find(field, net_options(), {true, {}}, enough);
    ASSERT_TRUE(found);
    EXPECT_GT(enough.memory().reserved(), 0U);
  }
  EXPECT_EQ(enough.memory().reserved(), 0U);
  enough.cancel();
  EXPECT_EQ(LabelVoxels::find(field, net_options(), {true, {}}, enough).error().code, ErrorCode::cancelled);
}

// Label of blocks of `side` voxels along each axis, counted from 1.
int block_label(int side, int blocks, int x, int y, int z) {
  return 1 + x / side + blocks * (y / side + blocks * (z / side));
}

std::uint64_t work_on(int blocks) {
  constexpr int kSide = 8;
  const field::ScalarField field = test::dense_field<std::uint16_t>(
      glm::ivec3(kSide * blocks), [&](int x, int y, int z) { return block_label(kSide, blocks, x, y, z); });
  const auto found = LabelVoxels::find(field, net_options(0), {true, {}}, Context());
  EXPECT_TRUE(found);
  std::uint64_t chunks = 0;
  for (const std::int64_t label : found->labels()) {
    const auto extraction = found->extract(field, label, net_options(0), Context());
    EXPECT_TRUE(extraction);
    EXPECT_EQ(extraction->stats.bricks_visited, found->find(label)->chunks);
    chunks += extraction->stats.bricks_visited;
  }
  return chunks;
}

// Counts instead of times: 64 times the labels, 64 times the work, whatever the size of the map.
TEST(LabelNets, DoesWorkInProportionToLabels) {
  EXPECT_EQ(work_on(2), 8U);
  EXPECT_EQ(work_on(8), 512U);
}

TEST(LabelNets, CountsVoxelsAndFindsBounds) {
  std::mt19937 engine(7);
  const glm::ivec3 dims(70, 11, 9);
  std::vector<int> samples;
  for (int n = 0; n < dims.x * dims.y * dims.z; ++n) samples.push_back(static_cast<int>(engine() % 40) - 5);
  const auto at = [&](int x, int y, int z) { return samples[static_cast<std::size_t>((z * dims.y + y) * dims.x + x)]; };
  const field::ScalarField field = test::dense_field<std::int16_t>(dims, at);
  ExtractOptions options = net_options(0);
  options.region = field::IndexBox{{3, 1, 2}, {68, 10, 7}};
  std::map<int, FoundLabel> expected;
  for (int z = 2; z <= 7; ++z) {
    for (int y = 1; y <= 10; ++y) {
      for (int x = 3; x <= 68; ++x) {
        FoundLabel& label = expected[at(x, y, z)];
        const glm::ivec3 p(x, y, z);
        label.bounds = label.voxels == 0
                           ? field::IndexBox{p, p}
                           : field::IndexBox{glm::min(label.bounds.min, p), glm::max(label.bounds.max, p)};
        ++label.voxels;
      }
    }
  }
  const auto found = LabelVoxels::find(field, options, {true, {}, 3}, Context());
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(found->find(3), nullptr);  // the background
  expected.erase(3);
  ASSERT_EQ(found->labels().size(), expected.size());
  EXPECT_TRUE(std::ranges::is_sorted(found->labels()));
  for (const auto& [label, right] : expected) {
    const FoundLabel* const entry = found->find(label);
    ASSERT_NE(entry, nullptr);
    EXPECT_EQ(entry->voxels, right.voxels) << label;
    EXPECT_EQ(entry->bounds, right.bounds) << label;
  }
}

// Samples that index ids give the meshes of the ids themselves.
TEST(LabelNets, KeepsIdsThatDoublesCannot) {
  constexpr std::int64_t kLarge = 720575940600000017;
  const std::vector<std::int64_t> ids{0, -9, kLarge, kLarge + 1};
  const glm::ivec3 dims(9, 7, 5);
  const auto index = [](int x, int y, int z) { return (x / 3 + 2 * (y / 4) + z / 3) % 4; };
  field::ScalarField indexed = test::dense_field<std::uint32_t>(dims, index);
  indexed.label_ids = std::make_shared<const std::vector<std::int64_t>>(ids);
  const auto small = [&](int x, int y, int z) {
    return std::array{0, -9, 4, 5}[static_cast<std::size_t>(index(x, y, z))];
  };
  const Labels expected = nets_of(test::dense_field<std::int16_t>(dims, small));
  const Labels meshes = nets_of(indexed);
  ASSERT_EQ(meshes.size(), 3U);
  for (const auto& [id, same] : {std::pair(std::int64_t{-9}, -9), std::pair(kLarge, 4), std::pair(kLarge + 1, 5)}) {
    ASSERT_TRUE(meshes.contains(id));
    EXPECT_EQ(test::triangle_set(meshes.at(id)), test::triangle_set(expected.at(same)));
  }
  const Labels listed = nets_of(indexed, net_options(), {false, {kLarge + 1, 0}});
  EXPECT_EQ(listed.size(), 2U);
  EXPECT_FALSE(listed.at(0).triangles.empty());
  const auto none = LabelVoxels::find(indexed, net_options(), {false, {4}}, Context());
  ASSERT_TRUE(none);
  EXPECT_EQ(none->find(4), nullptr);
}

}  // namespace
}  // namespace isoextract::extract

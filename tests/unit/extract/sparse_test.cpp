// Compares the sparse extractor with the dense one, which has no blocks or tiles.
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include <gtest/gtest.h>

#include "extract/sparse_blocks.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::extract {
namespace {

class Sparse : public testing::TestWithParam<Method> {
 protected:
  static void expect_same_as_dense(const field::ScalarField& dense, const field::ScalarField& sparse, double iso) {
    const ExtractOptions options = test::options_of(GetParam(), iso);
    const mesh::Mesh a = test::extract(dense, options).mesh;
    const Extraction b = test::extract(sparse, options);
    EXPECT_FALSE(a.triangles.empty());
    EXPECT_EQ(test::triangle_set(a), test::triangle_set(b.mesh));
    test::expect_sound(b.mesh, true);
  }
};
INSTANTIATE_TEST_SUITE_P(Methods, Sparse, testing::ValuesIn(test::all_methods()), test::method_name);

class SparseNormals : public Sparse {};
INSTANTIATE_TEST_SUITE_P(Methods, SparseNormals, testing::ValuesIn(test::methods_with(&MethodTraits::gradient_normals)),
                         test::method_name);

// Noise in blocks; some blocks are constant inside, constant outside, or background. The outermost layer is background,
// so that dense and sparse fields have the same surface.
TEST_P(Sparse, NoiseWithTilesEqualsDense) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    std::mt19937 engine(seed);
    std::uniform_int_distribution<int> value(0, seed % 2 == 0 ? 4 : 1000);
    std::uniform_int_distribution<int> kind(0, 3);
    std::map<std::tuple<int, int, int>, int> kinds;
    const glm::ivec3 dims(40, 32, 24);
    const field::ScalarField dense = test::dense_field<float>(dims, [&](int i, int j, int k) {
      const int random = value(engine);
      const auto block = std::tuple(i / 8, j / 8, k / 8);
      if (!kinds.contains(block)) kinds[block] = kind(engine);
      const glm::ivec3 p(i, j, k);
      if (glm::any(glm::equal(p, glm::ivec3(0))) || glm::any(glm::equal(p, dims - 1))) return -1;
      switch (kinds[block]) {
        case 0: return -1;    // background
        case 1: return 2000;  // inside
        default: return random;
      }
    });
    SCOPED_TRACE(seed);
    expect_same_as_dense(dense, test::sparse_copy<float>(dense, -1), 2);
  }
}

TEST_P(Sparse, MeshesTileSkins) {
  // A 16^3 box of tiles in background, with nothing stored near it.
  const glm::ivec3 dims(48, 48, 48);
  const auto value = [](int i, int j, int k) {
    return i >= 16 && i < 32 && j >= 16 && j < 32 && k >= 16 && k < 32 ? 3 : 0;
  };
  const field::ScalarField dense = test::dense_field<double>(dims, value);
  field::ScalarField sparse = test::sparse_copy<double>(dense, 0);
  auto& samples = std::get<field::SparseSamples>(sparse.samples);
  EXPECT_EQ(samples.blocks.size(), 2U);  // the two that mark the box
  EXPECT_EQ(samples.tiles.size(), 8U);
  expect_same_as_dense(dense, sparse, 1);
  // The same box as one large tile.
  samples.tiles = {{glm::ivec3(16), 16, 3.0}};
  expect_same_as_dense(dense, sparse, 1);
}

TEST_P(Sparse, ExtractsNegativeIndicesAndLevelSets) {
  const field::ScalarField dense = field::make_demo_field("demo:sphere?size=32", Context()).value();
  field::ScalarField level_set = test::dense_field<float>({32, 32, 32}, [&](int i, int j, int k) {
    return -static_cast<const float*>(std::get<field::DenseSamples>(dense.samples).data)[i + 32 * (j + 32 * k)];
  });
  level_set.kind = field::FieldKind::level_set;
  field::ScalarField sparse = test::sparse_copy<float>(level_set, 5);
  for (field::SparseBlock& block : std::get<field::SparseSamples>(sparse.samples).blocks) block.origin -= 16;
  const MethodTraits& traits = test::traits_of(GetParam());
  ExtractOptions options = test::options_of(GetParam(), 0);
  options.smooth_normals = traits.gradient_normals;
  const mesh::Mesh mesh = test::extract(sparse, options).mesh;
  test::expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).genus(), 0);
  const double radius = 0.7 * 31 / 2;
  const glm::dvec3 center(15.5 - 16);
  // If the surface does not follow the field, a vertex may be anywhere in a cell that the sphere passes.
  const double tolerance = traits.follows_interpolant ? 0.05 : std::sqrt(3.0);
  ASSERT_EQ(mesh.normals.size(), traits.gradient_normals ? mesh.positions.size() : 0);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::dvec3 out = mesh.position(v) - center;
    EXPECT_NEAR(glm::length(out), radius, tolerance);
    if (!traits.gradient_normals) continue;
    EXPECT_GT(glm::dot(glm::dvec3(mesh.normals[v]), glm::normalize(out)), 0.99);
  }
}

TEST_P(SparseNormals, EqualDense) {
  const field::ScalarField dense = field::make_demo_field("demo:metaballs?size=40", Context()).value();
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  ExtractOptions options = test::options_of(GetParam(), 0);
  options.smooth_normals = true;
  const mesh::Mesh a = test::extract(dense, options).mesh;
  const mesh::Mesh b = test::extract(sparse, options).mesh;
  std::map<test::Point, glm::vec3> normals;
  for (std::size_t v = 0; v < a.positions.size(); ++v) {
    normals[{a.positions[v].x, a.positions[v].y, a.positions[v].z}] = a.normals[v];
  }
  ASSERT_EQ(a.positions.size(), b.positions.size());
  ASSERT_EQ(b.normals.size(), b.positions.size());
  for (std::size_t v = 0; v < b.positions.size(); ++v) {
    EXPECT_EQ((normals[{b.positions[v].x, b.positions[v].y, b.positions[v].z}]), b.normals[v]);
  }
}

// Returns the number of bricks of a dense field with samples on both sides of 0. A brick includes `beyond` samples past
// each of its ends.
std::uint64_t count_crossed(const field::DenseSamples& samples, const glm::ivec3& brick, int beyond) {
  const auto* values = static_cast<const float*>(samples.data);
  std::uint64_t crossed = 0;
  for (int z = 0; z < samples.dims.z; z += brick.z) {
    for (int y = 0; y < samples.dims.y; y += brick.y) {
      for (int x = 0; x < samples.dims.x; x += brick.x) {
        const glm::ivec3 low = glm::max(glm::ivec3(x, y, z) - beyond, glm::ivec3(0));
        const glm::ivec3 high = glm::min(glm::ivec3(x, y, z) + brick + beyond, samples.dims);
        std::array<bool, 2> sides{};
        for (int k = low.z; k < high.z; ++k) {
          for (int j = low.y; j < high.y; ++j) {
            for (int i = low.x; i < high.x; ++i) {
              sides[values[i + samples.dims.x * (j + samples.dims.y * k)] > 0 ? 1 : 0] = true;
            }
          }
        }
        crossed += sides[0] && sides[1] ? 1 : 0;
      }
    }
  }
  return crossed;
}

TEST_P(Sparse, VisitsOnlyCrossedBricks) {
  const field::ScalarField dense = field::make_demo_field("demo:sphere?size=128", Context()).value();
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -9);
  const ExtractStats stats = test::extract(sparse, test::options_of(GetParam(), 0)).stats;
  glm::ivec3 brick(0);
  ASSERT_EQ(std::sscanf(stats.brick.c_str(), "%dx%dx%d ", &brick.x, &brick.y, &brick.z), 3) << stats.brick;
  EXPECT_EQ(stats.bricks, std::uint64_t{128} * 128 * 128 / static_cast<std::uint64_t>(brick.x * brick.y * brick.z));
  const auto& samples = std::get<field::DenseSamples>(dense.samples);
  EXPECT_GE(stats.bricks_visited, count_crossed(samples, brick, 0));
  EXPECT_LE(stats.bricks_visited, count_crossed(samples, brick, 1));
  EXPECT_LT(stats.bricks_visited, stats.bricks / (brick == glm::ivec3(8) ? 4 : 2));
  EXPECT_GT(stats.bricks_visited, 0U);
}

// A tile as small as a block is itself a place without a block.
TEST(SparsePlaces, ReservesMemoryForSmallTiles) {
  field::SparseSamples samples;
  samples.background = -1;
  for (int n = 0; n < 3; ++n) samples.tiles.push_back({{32 * n, 0, 0}, 8, 1});
  const field::SparseLookup lookup(samples);
  const auto places = find_unstored_places(samples, lookup, {{1, 1, 1}, false});
  EXPECT_EQ(places.size(), 3U * 8);
  EXPECT_GE(unstored_places_bytes(samples, lookup.nodes().size()), 3 * places.size() * sizeof(glm::ivec3));
}

TEST_P(Sparse, RefusesBlocksAtEndsOfIndexRange) {
  const field::ScalarField dense = field::make_demo_field("demo:sphere?size=8", Context()).value();
  field::ScalarField field = test::sparse_copy<float>(dense, -1);
  auto& samples = std::get<field::SparseSamples>(field.samples);
  samples.blocks.push_back(samples.blocks[0]);
  samples.blocks[0].origin = glm::ivec3(-field::kMaxSparseIndex);
  samples.blocks[1].origin = glm::ivec3(field::kMaxSparseIndex - 8);
  const ExtractOptions options = test::options_of(GetParam(), 0);
  EXPECT_FALSE(make_cpu_extractor()->extract(field, options, Context())) << "float32 cannot hold them apart";
  // At a distance of 2^16 they are two whole spheres.
  samples.blocks[0].origin = glm::ivec3(-(1 << 15));
  samples.blocks[1].origin = glm::ivec3(1 << 15);
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  test::expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).components, 2U);
}

TEST_P(Sparse, IgnoresNanOutsideRegion) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const field::ScalarField dense = test::dense_field<float>({32, 32, 32}, [&](int i, int j, int k) {
    if (i == 30 && j == 30 && k == 30) return nan;
    return i > 1 && i < 6 && j > 1 && j < 6 && k > 1 && k < 6 ? 1.0 : -1.0;
  });
  const field::ScalarField sparse = test::sparse_copy<float>(dense, -1);
  for (const field::ScalarField* field : {&dense, &sparse}) {
    ExtractOptions options = test::options_of(GetParam(), 0);
    EXPECT_FALSE(make_cpu_extractor()->extract(*field, options, Context()));
    options.region = field::IndexBox{glm::ivec3(0), glm::ivec3(9)};
    test::expect_sound(test::extract(*field, options).mesh, true);
  }
}

// If the background is inside, a capped region is the region minus the bubbles in it.
TEST_P(Sparse, CapsRegionInInsideBackground) {
  const field::ScalarField dense = field::make_demo_field("demo:sphere?size=8", Context()).value();
  field::ScalarField field = test::sparse_copy<float>(dense, -1);
  field.kind = field::FieldKind::level_set;  // now the sphere is outside
  ExtractOptions options = test::options_of(GetParam(), 0, true);
  options.region = field::IndexBox{glm::ivec3(-20), glm::ivec3(30)};
  const mesh::Mesh mesh = test::extract(field, options).mesh;
  test::expect_sound(mesh, true);
  const double reach = test::reach_beyond_samples(GetParam());
  EXPECT_EQ(mesh::measure_bounds(mesh).min, glm::dvec3(-20 - reach));
  EXPECT_EQ(mesh::measure_bounds(mesh).max, glm::dvec3(30 + reach));
  EXPECT_EQ(mesh::measure_topology(mesh).components, 2U);
}

// Without a region the surface consists of the cavities alone, and the enclosed space is outside.
TEST_P(Sparse, ExtractsCavitiesInInsideBackground) {
  const field::ScalarField dense = test::dense_field<float>({160, 16, 16}, [](int i, int j, int k) {
    const auto from = [&](double x) { return glm::length(glm::dvec3(i, j, k) - glm::dvec3(x, 7.4, 7.7)); };
    return std::min(from(8.2), from(150.9)) - 5;
  });
  const field::ScalarField field = test::sparse_copy<float>(dense, 5);
  const mesh::Mesh mesh = test::extract(field, test::options_of(GetParam(), 0)).mesh;
  test::expect_sound(mesh, true);
  EXPECT_EQ(mesh::measure_topology(mesh).components, 2U);
  const double balls = 2 * 4.0 / 3 * std::numbers::pi * std::pow(5.0, 3);
  EXPECT_NEAR(mesh::measure_size(mesh).volume, -balls, 0.05 * balls);
}

TEST_P(Sparse, EmptyGridGivesEmptyMesh) {
  field::ScalarField field;
  field.samples = field::SparseSamples{};
  EXPECT_TRUE(test::extract(field, test::options_of(GetParam(), 0)).mesh.triangles.empty());
}

}  // namespace
}  // namespace isoextract::extract

// Compares voxels of sparse samples with dense ones, which have no blocks, and voxels of labels with one label at a
// time.
#include <gtest/gtest.h>

#include "extract/voxels.hpp"
#include "support/voxel_patterns.hpp"

namespace isoextract::extract {
namespace {

void expect_same_bytes(const mesh::Mesh& a, const mesh::Mesh& b) {
  EXPECT_TRUE(std::equal(a.positions.begin(), a.positions.end(), b.positions.begin(), b.positions.end()));
  EXPECT_TRUE(std::equal(a.triangles.begin(), a.triangles.end(), b.triangles.begin(), b.triangles.end()));
}

// Noise in some blocks; others are entirely inside or outside.
field::ScalarField blocky_field(unsigned seed, int values) {
  std::mt19937 engine(seed);
  std::array<int, 12 * 4 * 4> kinds{};
  for (int& kind : kinds) kind = static_cast<int>(engine() % 4);
  return test::dense_field<std::int16_t>({96, 32, 32}, [&](int x, int y, int z) {
    const int random = static_cast<int>(engine() % static_cast<unsigned>(values));
    const int kind = kinds[static_cast<std::size_t>(x / 8 + 12 * (y / 8 + 4 * (z / 8)))];
    return kind == 0 ? 0 : kind == 1 ? 1 : random;
  });
}

TEST(VoxelsSparse, EqualsDenseBytes) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    SCOPED_TRACE(seed);
    const field::ScalarField dense = blocky_field(seed, 2 + static_cast<int>(seed));
    const field::ScalarField sparse = test::sparse_copy<std::int16_t>(dense, 0);
    for (const VoxelFaces faces : {VoxelFaces::merged, VoxelFaces::plain, VoxelFaces::rectangles}) {
      ExtractOptions options = test::voxel_options(faces);
      const mesh::Mesh mesh = test::extract(sparse, options).mesh;
      EXPECT_FALSE(mesh.triangles.empty());
      expect_same_bytes(test::extract(dense, options).mesh, mesh);
      options.region = field::IndexBox{{5, 3, 8}, {77, 30, 20}};
      const mesh::Mesh part = test::extract(sparse, options).mesh;
      if (faces != VoxelFaces::rectangles) test::expect_sound(part, true);
      EXPECT_EQ(test::exact_volume(test::extract(dense, options).mesh), test::exact_volume(part));
    }
  }
}

field::ScalarField tiles(std::vector<field::SparseTile> list, double background) {
  field::ScalarField field;
  field.source = "tiles";
  field::SparseSamples samples;
  samples.type = field::SampleType::f32;
  samples.tiles = std::move(list);
  samples.background = background;
  field.samples = std::move(samples);
  return field;
}

// Two voxel cubes a million voxels apart, and a large tile: the space between and in them costs nothing.
TEST(VoxelsSparse, CostsLittleForFarLargeTiles) {
  const Context context{MemoryBudget(std::uint64_t{256} << 20)};
  const auto far = make_cpu_extractor()->extract(tiles({{{-499968, 0, 0}, 8, 1}, {{499968, 8, -499968}, 8, 1}}, 0),
                                                 test::voxel_options(), context);
  ASSERT_TRUE(far) << far.error().message;
  EXPECT_EQ(far->mesh.triangles.size(), 24U);
  test::expect_sound(far->mesh, true);
  EXPECT_LT(context.memory().peak(), std::uint64_t{1} << 20);
  const auto large = make_cpu_extractor()->extract(tiles({{{0, 0, 0}, 4096, 1}}, 0), test::voxel_options(), context);
  ASSERT_TRUE(large) << large.error().message;
  EXPECT_EQ(large->mesh.triangles.size(), 12U);
  EXPECT_EQ(test::exact_volume(large->mesh), 4096.0 * 4096 * 4096);
}

// The background is inside: the surface is that of the cavity, with reversed winding, and a region closes it.
TEST(VoxelsSparse, MeshesInsideBackground) {
  const field::ScalarField field = tiles({{{8, 8, 8}, 8, 0}, {{128, 0, 0}, 128, 0}}, 1);
  const mesh::Mesh cavities = test::extract(field, test::voxel_options()).mesh;
  test::expect_sound(cavities, true);
  EXPECT_EQ(cavities.triangles.size(), 24U);
  EXPECT_EQ(test::exact_volume(cavities), -(512.0 + 128 * 128 * 128));
  ExtractOptions options = test::voxel_options();
  options.region = field::IndexBox{{-100, -3, -50}, {130, 30, 20}};
  const mesh::Mesh part = test::extract(field, options).mesh;
  test::expect_sound(part, true);
  EXPECT_EQ(test::exact_volume(part), 231.0 * 34 * 71 - 512 - 3 * 31 * 21);
}

// Compares each label with the voxels of that value.
TEST(VoxelsSparse, FindsEveryLabel) {
  const field::ScalarField dense = blocky_field(3, 6);
  const field::ScalarField sparse = test::sparse_copy<std::int16_t>(dense, 0);
  ExtractOptions options = test::voxel_options();
  for (const field::ScalarField* field : {&dense, &sparse}) {
    for (const bool cut : {false, true}) {
      options.region.reset();
      if (cut) options.region = field::IndexBox{{5, 3, 8}, {77, 30, 20}};
      const auto labels = LabelVoxels::find(*field, options, {true, {}}, Context());
      ASSERT_TRUE(labels) << labels.error().message;
      EXPECT_EQ(labels->labels(), (std::vector<std::int64_t>{1, 2, 3, 4, 5}));
      for (const std::int64_t label : labels->labels()) {
        SCOPED_TRACE(label);
        const auto* values = static_cast<const std::int16_t*>(std::get<field::DenseSamples>(dense.samples).data);
        const field::ScalarField one = test::dense_field<std::uint8_t>(
            {96, 32, 32}, [&](int x, int y, int z) { return values[x + 96 * (y + 32 * z)] == label ? 1 : 0; });
        const auto found = labels->extract(*field, label, options, Context());
        ASSERT_TRUE(found);
        test::expect_sound(found->mesh, true);
        const mesh::Mesh expected = test::extract(one, options).mesh;
        EXPECT_EQ(test::exact_volume(found->mesh), test::exact_volume(expected));
        if (!cut) expect_same_bytes(expected, found->mesh);
      }
    }
  }
}

TEST(VoxelsSparse, FindsChosenLabels) {
  const field::ScalarField field = blocky_field(1, 6);
  const auto some = LabelVoxels::find(field, test::voxel_options(), {false, {4, 99, 0}}, Context());
  ASSERT_TRUE(some);
  EXPECT_EQ(some->labels(), (std::vector<std::int64_t>{4, 99, 0}));
  EXPECT_TRUE(some->extract(field, 99, test::voxel_options(), Context())->mesh.triangles.empty());
  EXPECT_FALSE(some->extract(field, 0, test::voxel_options(), Context())->mesh.triangles.empty());
  EXPECT_TRUE(some->extract(field, 1, test::voxel_options(), Context())->mesh.triangles.empty());
  const auto refused =
      LabelVoxels::find(test::sparse_copy<std::int16_t>(field, 0), test::voxel_options(), {false, {0}}, Context());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("label 0 is the background"), std::string::npos);
  EXPECT_TRUE(
      LabelVoxels::find(test::random_field<float>({8, 8, 8}, 1, 3), test::voxel_options(), {true, {}}, Context()));
  const auto halves = LabelVoxels::find(
      test::dense_field<float>({4, 4, 4}, [](int x, int /*y*/, int /*z*/) { return 0.5F * static_cast<float>(x); }),
      test::voxel_options(), {true, {}}, Context());
  ASSERT_FALSE(halves);
  EXPECT_NE(halves.error().message.find("whole numbers"), std::string::npos) << halves.error().message;
}

}  // namespace
}  // namespace isoextract::extract

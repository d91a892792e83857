// Tests grid tools of the OpenVDB plug-in if it was built, and the messages without it.
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <numbers>

#include <openvdb/tools/Diagnostics.h>
#include <openvdb/tools/LevelSetMeasure.h>
#include <openvdb/tools/LevelSetSphere.h>

#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"
#include "volume_io/grid_tools.hpp"

namespace isoextract::test {
namespace {

#define NEEDS_OPENVDB_PLUGIN() \
  if (!BUILT_OPENVDB) GTEST_SKIP() << "the plug-ins around OpenVDB were not built"

// Sets the folder in which grid tools look for their plug-in, during its lifetime.
class PluginFolder {
 public:
  explicit PluginFolder(const std::string& folder) { ::setenv("ISOEXTRACT_PLUGINS", folder.c_str(), 1); }
  PluginFolder(const PluginFolder&) = delete;
  PluginFolder& operator=(const PluginFolder&) = delete;
  ~PluginFolder() { ::unsetenv("ISOEXTRACT_PLUGINS"); }
};

const auto& samples_of(const field::ScalarField& field) { return std::get<field::SparseSamples>(field.samples); }

// A sparse field with blocks, tiles, a negative zero and unusual bits.
field::ScalarField sparse_field(std::vector<float>& values) {
  values.resize(2 * 512);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = std::sin(static_cast<float>(i)) * (i % 5 == 0 ? 0 : 1e-3F);
  values[3] = -0.0F;
  values[7] = 3e38F;
  values[600] = 1e-41F;
  field::SparseSamples samples;
  samples.blocks = {{{-16, 8, 0}, values.data()}, {{24, 0, -8}, values.data() + 512}};
  samples.tiles = {{{128, 0, 0}, 16, 2.5}, {{4096, 4096, 0}, 4096, -7}};
  samples.background = 0;
  field::ScalarField field;
  field.name = "smoke";
  field.source = "made by hand";
  field.index_to_world = {glm::dmat3(0.5, 0.1, 0, 0, 0.25, 0, 0, 0, 2), glm::dvec3(1e6, -3, 1.0 / 3)};
  field.samples = std::move(samples);
  return field;
}

TEST(OpenVdbTools, WritesSeveralGrids) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  std::vector<float> values;
  std::vector<field::ScalarField> fields(2, sparse_field(values));
  fields[1].name = "fog";
  fields[1].index_to_world = {};
  const TempFolder folder;
  const auto written = volume_io::write_vdb(folder / "w.vdb", fields, Context());
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(*written, std::filesystem::file_size(folder / "w.vdb"));
  for (const field::ScalarField& field : fields) {
    volume_io::ReadOptions options;
    options.grid = field.name;
    const auto read = volume_io::read_volume(folder / "w.vdb", options, Context());
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->index_to_world, field.index_to_world);
    EXPECT_EQ(samples_of(*read).blocks.size(), samples_of(field).blocks.size());
  }
}

TEST(OpenVdbTools, WritesSparseFieldsBitForBit) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  std::vector<float> values;
  const field::ScalarField field = sparse_field(values);
  const TempFolder folder;
  const auto written = volume_io::write_vdb(folder / "w.vdb", field, {}, Context());
  ASSERT_TRUE(written) << written.error().message;
  const field::ScalarField read = must_read(folder / "w.vdb");
  EXPECT_EQ(read.name, "smoke");
  EXPECT_EQ(read.kind, field::FieldKind::density);
  EXPECT_EQ(read.index_to_world, field.index_to_world);
  const auto& samples = samples_of(read);
  ASSERT_EQ(samples.blocks.size(), 2U);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(std::memcmp(samples.blocks[b].values, values.data() + 512 * b, 2048), 0) << b;
  }
  EXPECT_EQ(sparse_value<float>(samples, {143, 15, 15}), 2.5);
  EXPECT_EQ(sparse_value<float>(samples, {144, 0, 0}), 0);
  EXPECT_EQ(sparse_value<float>(samples, {5000, 8191, 4095}), -7);
  volume_io::VdbWriteOptions half;
  half.as_half = true;
  half.name = "other";
  ASSERT_TRUE(volume_io::write_vdb(folder / "h.vdb", field, half, Context()));
  const field::ScalarField halves = must_read(folder / "h.vdb");
  EXPECT_EQ(halves.name, "other");
  const auto* rounded = static_cast<const float*>(samples_of(halves).blocks[0].values);
  // 11 bits of mantissa; below 2^-14 in steps of 2^-24.
  for (std::size_t i = 8; i < 512; ++i) {
    EXPECT_NEAR(rounded[i], values[i], std::max(std::abs(values[i]) * 0x1p-11F, 0x1p-25F)) << i;
  }
  EXPECT_LT(std::filesystem::file_size(folder / "h.vdb"), std::filesystem::file_size(folder / "w.vdb"));
}

TEST(OpenVdbTools, WritesDenseFieldsAtomically) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  const std::vector<std::uint8_t> bytes{5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22};
  field::DenseSamples dense;
  dense.type = field::SampleType::u8;
  dense.dims = {9, 2, 1};
  dense.data = bytes.data();
  field::ScalarField field;
  field.name = "box";
  field.scale = {2, -1};
  field.samples = dense;
  const TempFolder folder;
  ASSERT_TRUE(volume_io::write_vdb(folder / "d.vdb", field, {}, Context()));
  const field::ScalarField read = must_read(folder / "d.vdb");
  const auto& samples = samples_of(read);
  EXPECT_EQ(samples.background, 9);  // the least value
  EXPECT_EQ(sparse_value<float>(samples, {0, 0, 0}), 9);
  EXPECT_EQ(sparse_value<float>(samples, {8, 1, 0}), 43);
  EXPECT_EQ(sparse_value<float>(samples, {3, 1, 0}), 2 * 17 - 1);
  EXPECT_EQ(sparse_value<float>(samples, {9, 0, 0}), 9);
  const auto refused = volume_io::write_vdb(folder / "e.vdb", field, {}, with_memory(100));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_FALSE(std::filesystem::exists(folder / "e.vdb"));
}

TEST(OpenVdbTools, ReservesNodesAboveScatteredBricks) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  std::vector<float> values;
  field::ScalarField field = sparse_field(values);
  auto& samples = std::get<field::SparseSamples>(field.samples);
  for (int i = 1; i < 64; ++i) samples.blocks.push_back({{4096 * i, 0, 0}, values.data()});
  const TempFolder folder;
  // Each has a lower node with 16^3 pointers and an upper node with 32^3.
  const auto refused = volume_io::write_vdb(folder / "w.vdb", field, {}, with_memory(std::uint64_t{12} << 20));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_TRUE(volume_io::write_vdb(folder / "w.vdb", field, {}, with_memory(std::uint64_t{40} << 20)));
}

points::ParticleSet two_balls() {
  points::ParticleSet set;
  set.label = "two balls";
  set.positions = Buffer<glm::dvec3>(2);
  set.positions[0] = {0.3, 0.2, 0.1};
  set.positions[1] = {5, 5, 5};
  return set;
}

// Returns the volume where a level set is negative, counting each voxel's inside part to first order.
double inner_volume(const field::ScalarField& field, double reach) {
  const double voxel = field.index_to_world.linear[0][0];
  const int last = static_cast<int>(reach / voxel);
  double sum = 0;
  for (int x = -last; x <= last; ++x) {
    for (int y = -last; y <= last; ++y) {
      for (int z = -last; z <= last; ++z) {
        const double distance = sparse_value<float>(samples_of(field), {x, y, z});
        sum += std::clamp(0.5 - distance / voxel, 0.0, 1.0);
      }
    }
  }
  return sum * voxel * voxel * voxel;
}

TEST(OpenVdbTools, KeepsTheVolumeOfSpheres) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  volume_io::SphereOptions options;
  const std::array<float, 2> radii{1.0F, 0.01F};
  options.radii = radii;
  options.voxel = 0.125;
  const Context context;
  {
    const auto field = volume_io::rasterize_spheres(two_balls(), options, context);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_EQ(field->field.kind, field::FieldKind::level_set);
    EXPECT_EQ(samples_of(field->field).background, 0.375);
    EXPECT_NEAR(inner_volume(field->field, 2), 4.0 / 3 * std::numbers::pi, 0.03);
    EXPECT_NEAR(sparse_value<float>(samples_of(field->field), {10, 2, 1}), std::hypot(0.95, 0.05, 0.025) - 1, 1e-6);
    EXPECT_TRUE(has_note(field->field, "leaves out 1 of 2 particles, those with a radius below 1.5 voxels"));
    EXPECT_EQ(field->left_out, 1U);
    EXPECT_GT(context.memory().reserved(), 0U);
    options.radii = {};
    options.radius = 1;
    options.kind = field::FieldKind::density;
    const auto fog = volume_io::rasterize_spheres(two_balls(), options, context);
    ASSERT_TRUE(fog) << fog.error().message;
    EXPECT_EQ(fog->field.kind, field::FieldKind::density);
    EXPECT_EQ(sparse_value<float>(samples_of(fog->field), {40, 40, 40}), 1);
    EXPECT_EQ(sparse_value<float>(samples_of(fog->field), {20, 20, 20}), 0);
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST(OpenVdbTools, ReservesMemoryWhileCountingLeaves) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  volume_io::SphereOptions options;
  options.radius = 1;
  options.voxel = 0.001;
  constexpr std::uint64_t kLimit = std::uint64_t{16} << 20;
  const Context context = with_memory(kLimit);
  EXPECT_FALSE(volume_io::rasterize_spheres(two_balls(), options, context));
  EXPECT_GT(context.memory().peak(), kLimit / 2);  // rejected while counting
}

// Also if its radius is larger than the search radius.
TEST(OpenVdbTools, MakesASphereOfASingleSmoothSphere) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  for (const double search_radius : {2.0, 0.5}) {
    volume_io::SphereOptions options;
    options.method = volume_io::SphereMethod::smooth;
    options.radius = 1;
    options.search_radius = search_radius;
    options.voxel = 0.125;
    const auto field = volume_io::rasterize_spheres(two_balls(), options, Context());
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_NEAR(inner_volume(field->field, 2), 4.0 / 3 * std::numbers::pi, 0.03) << search_radius;
  }
}

TEST(OpenVdbTools, BoundsTheMemoryOfSpheres) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  for (const auto method : {volume_io::SphereMethod::spheres, volume_io::SphereMethod::smooth}) {
    volume_io::SphereOptions options;
    options.method = method;
    options.radius = 1;
    options.search_radius = 2;
    options.voxel = 0.05;
    const Context context;
    const auto bytes = volume_io::sphere_bytes(two_balls(), options, context);
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_EQ(context.memory().reserved(), 0U);
    const auto field = volume_io::rasterize_spheres(two_balls(), options, context);
    ASSERT_TRUE(field);
    EXPECT_GE(context.memory().peak(), *bytes);
    EXPECT_LT(context.memory().reserved(), *bytes);
    options.voxel = 0.1;
    EXPECT_LT(volume_io::sphere_bytes(two_balls(), options, context).value(), *bytes / 3);
  }
}

// Between two spheres at the same distance from both, the averaged position is the middle itself.
TEST(OpenVdbTools, MakesNoBodyBetweenDistantSpheres) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  volume_io::SphereOptions options;
  options.method = volume_io::SphereMethod::smooth;
  options.radius = 1;
  options.search_radius = 4;
  options.voxel = 0.25;
  for (const double distance : {3.0, 4.0, 5.0, 6.0, 7.0}) {
    points::ParticleSet set = two_balls();
    set.positions[0] = {-distance / 2, 0, 0};
    set.positions[1] = {distance / 2, 0, 0};
    const auto field = volume_io::rasterize_spheres(set, options, Context());
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_LT(sparse_value<float>(samples_of(field->field), {static_cast<int>(2 * distance), 0, 0}), -0.5) << distance;
    if (distance < 5) continue;  // nearer spheres merge
    EXPECT_GE(sparse_value<float>(samples_of(field->field), {0, 0, 0}), 0) << distance;
    EXPECT_LT(inner_volume(field->field, distance / 2 + 3), 1.3 * 2 * 4.0 / 3 * std::numbers::pi) << distance;
  }
}

TEST(OpenVdbTools, SmoothsALevelSetByFilters) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  openvdb::initialize();
  const auto ball = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(1.0F, {0, 0, 0}, 0.125F);
  ball->setName("ball");
  // A dent of one voxel.
  ball->tree().setValue({8, 0, 0}, 0.2F);
  const TempFolder folder;
  write_vdb(folder / "b.vdb", {ball});
  const field::ScalarField field = must_read(folder / "b.vdb");
  for (const auto filter :
       {volume_io::LevelSetFilter::gaussian, volume_io::LevelSetFilter::median, volume_io::LevelSetFilter::mean}) {
    const auto filtered = volume_io::filter_level_set(field, filter, 1, 2, Context());
    ASSERT_TRUE(filtered) << filtered.error().message;
    EXPECT_EQ(filtered->kind, field::FieldKind::level_set);
    EXPECT_EQ(filtered->name, "ball");
    EXPECT_LT(sparse_value<float>(samples_of(*filtered), {8, 0, 0}), 0.1);
    // A box filter of three voxels has a variance of 2/3; a Gaussian is four of them. By mean curvature flow, dr/dt =
    // -2/r with t = 1/3 per box, a sphere of radius 8 moves by this distance.
    const double boxes = filter == volume_io::LevelSetFilter::gaussian ? 8 : 2;
    const double radius = std::sqrt(1 - 4.0 / 64 * boxes / 3);
    EXPECT_NEAR(inner_volume(*filtered, 2), 4.0 / 3 * std::numbers::pi * std::pow(radius, 3), 0.12) << boxes;
  }
  const auto none = volume_io::filter_level_set(field, volume_io::LevelSetFilter::mean, 1, 0, Context());
  ASSERT_TRUE(none);
  EXPECT_EQ(sparse_value<float>(samples_of(*none), {8, 0, 0}), static_cast<double>(0.2F));
  field::ScalarField density = field;
  density.kind = field::FieldKind::density;
  expect_in(volume_io::filter_level_set(density, volume_io::LevelSetFilter::mean, 1, 1, Context()).error().message,
            "expected a level set, found a density");
}

openvdb::FloatGrid::Ptr read_with_openvdb(const std::filesystem::path& path) {
  openvdb::io::File file(path.string());
  file.open();
  const auto grids = file.getGrids();
  return openvdb::gridPtrCast<openvdb::FloatGrid>(grids->front());
}

// OpenVDB judges the written file: finer and coarser, far from the origin and turned.
TEST(OpenVdbTools, RebuildsALevelSetWithAFullBand) {
  NEEDS_OPENVDB_PLUGIN();
  const PluginFolder plugins(BUILT_PLUGINS);
  openvdb::initialize();
  constexpr float kVoxel = 0.5F;
  constexpr float kRadius = 10;
  const TempFolder folder;
  for (const double far : {0.0, 1e7}) {
    const auto ball = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(kRadius, {3, -2, 5}, kVoxel);
    ball->transform().postRotate(0.3, openvdb::math::Z_AXIS);
    ball->transform().postTranslate({far, -far, 0});
    write_vdb(folder / "ball.vdb", {ball});
    const field::ScalarField field = must_read(folder / "ball.vdb");
    for (const double step : {0.4, 1.7, 3.0}) {
      SCOPED_TRACE(testing::Message() << "step " << step << ", offset " << far);
      field::Affine lattice = field::scaling(glm::dvec3(step));
      lattice.offset = {0.25, 0, -7};
      const auto rebuilt = volume_io::rebuild_level_set(field, lattice, 3, Context());
      ASSERT_TRUE(rebuilt) << rebuilt.error().message;
      EXPECT_EQ(rebuilt->kind, field::FieldKind::level_set);
      EXPECT_EQ(rebuilt->index_to_world, field.index_to_world.after(lattice));
      ASSERT_TRUE(volume_io::write_vdb(folder / "rebuilt.vdb", *rebuilt, {}, Context()));
      const auto grid = read_with_openvdb(folder / "rebuilt.vdb");
      const double voxel = step * kVoxel;
      EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
      EXPECT_NEAR(grid->background(), 3 * voxel, 1e-5 * voxel);
      EXPECT_EQ(openvdb::tools::checkLevelSet(*grid), "");
      float low = 0;
      float high = 0;
      double error = 0;  // largest near the surface, and the mean of all
      double sum = 0;
      const openvdb::Vec3d middle = ball->transform().indexToWorld(openvdb::Vec3d(3, -2, 5) / kVoxel);
      for (auto value = grid->cbeginValueOn(); value; ++value) {
        low = std::min(low, *value);
        high = std::max(high, *value);
        const double known = (grid->indexToWorld(value.getCoord()) - middle).length() - kRadius;
        if (std::abs(known) < kVoxel) error = std::max(error, std::abs(known - *value));
        sum += std::abs(known - *value);
      }
      EXPECT_LE(low, -2.9 * voxel);
      EXPECT_GE(high, 2.9 * voxel);
      EXPECT_LT(error, 0.03 * kVoxel);
      EXPECT_LT(sum / static_cast<double>(grid->activeVoxelCount()), 0.05 * voxel);
      const auto same =
          openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(kRadius, {}, static_cast<float>(voxel));
      EXPECT_NEAR(openvdb::tools::levelSetVolume(*grid) / openvdb::tools::levelSetVolume(*same), 1, 0.01);
    }
  }
  EXPECT_FALSE(volume_io::rebuild_level_set(must_read(folder / "ball.vdb"), field::scaling({1, 2, 2}), 3, Context()));
  EXPECT_EQ(volume_io::rebuild_level_set(must_read(folder / "ball.vdb"), field::scaling(glm::dvec3(0.1)), 3,
                                         with_memory(std::uint64_t{8} << 20))
                .error()
                .hint,
            Hint(Remedy::raise, Setting::memory_limit));
}

TEST(OpenVdbTools, NamesTheMissingPlugin) {
  const PluginFolder plugins("/nowhere");
  const TempFolder folder;
  std::vector<float> values;
  const field::ScalarField field = sparse_field(values);
  volume_io::SphereOptions options;
  options.radius = options.voxel = 1;
  const auto expect_missing = [](const Error& error) {
    EXPECT_EQ(error.code, ErrorCode::unavailable);
    expect_in(error.message, "isoextract-grids-openvdb.so, which is in none of the folders /nowhere");
  };
  expect_missing(volume_io::write_vdb(folder / "w.vdb", field, {}, Context()).error());
  expect_missing(volume_io::filter_level_set(field, volume_io::LevelSetFilter::mean, 1, 1, Context()).error());
  expect_missing(volume_io::rebuild_level_set(field, {}, 3, Context()).error());
  expect_missing(volume_io::rasterize_spheres(two_balls(), options, Context()).error());
  EXPECT_FALSE(std::filesystem::exists(folder / "w.vdb"));
  options.voxel = 0;
  EXPECT_EQ(volume_io::rasterize_spheres(two_balls(), options, Context()).error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace isoextract::test

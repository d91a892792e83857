// Tests volumes read by the OpenVDB plug-in if it was built, and the messages without it.
#include <array>

#include <fmt/format.h>
#include <openvdb/tools/Interpolation.h>

#include "support/hints.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"
#include "volume_io/detail/formats.hpp"

namespace isoextract::test {
namespace {

#define NEEDS_OPENVDB_PLUGIN() \
  if (!BUILT_OPENVDB) GTEST_SKIP() << "the plug-ins around OpenVDB were not built"

const volume_io::VolumeFormat& vdb_with_plugin() {
  static const auto format = volume_io::make_vdb_format({std::filesystem::path(BUILT_PLUGINS)});
  return *format;
}

Result<field::ScalarField> try_grid(const std::filesystem::path& path, const std::string& grid = "",
                                    const Context& context = Context()) {
  volume_io::ReadOptions options;
  if (!grid.empty()) options.grid = grid;
  return vdb_with_plugin().open(path.string(), options, context);
}

field::ScalarField must_grid(const std::filesystem::path& path, const std::string& grid = "") {
  auto field = try_grid(path, grid);
  if (!field) throw std::runtime_error(field.error().message + "\n" + test::text_of(field.error().hint));
  return std::move(*field);
}

const auto& sparse_of(const field::ScalarField& field) { return std::get<field::SparseSamples>(field.samples); }

TEST(OpenVdbVolume, ReadsBoolsMasksAndLargeIntegers) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  const auto flags = two_voxels<openvdb::BoolGrid>("flags", true, true);
  flags->tree().addTile(2, {1280, 0, 0}, true, true);
  constexpr std::int64_t kLarge = (std::int64_t{1} << 53) + 1;
  openvdb::initialize();
  const auto mask = openvdb::MaskGrid::create();
  mask->setName("mask");
  mask->tree().setValueOn({5, 6, 7});
  write_vdb(folder / "v.vdb", {flags, mask, two_voxels<openvdb::Int64Grid>("large", 7, kLarge)});

  const field::ScalarField bools = must_grid(folder / "v.vdb", "flags");
  EXPECT_EQ(bools.type(), field::SampleType::u8);
  EXPECT_EQ(bools.name, "flags");
  EXPECT_EQ(bools.format, "OpenVDB");
  EXPECT_EQ(sparse_of(bools).active_voxels, 2U + 128U * 128U * 128U);
  EXPECT_EQ(sparse_value<std::uint8_t>(sparse_of(bools), {1, 2, 3}), 1);
  EXPECT_EQ(sparse_value<std::uint8_t>(sparse_of(bools), {1, 2, 4}), 0);
  EXPECT_EQ(sparse_value<std::uint8_t>(sparse_of(bools), {1300, 5, 127}), 1);
  expect_near(bools.index_to_world({2, 4, 6}), {1, 2, 3});

  const field::ScalarField masked = must_grid(folder / "v.vdb", "mask");
  EXPECT_EQ(sparse_value<std::uint8_t>(sparse_of(masked), {5, 6, 7}), 1);
  EXPECT_EQ(sparse_value<std::uint8_t>(sparse_of(masked), {5, 7, 6}), 0);

  const field::ScalarField large = must_grid(folder / "v.vdb", "large");
  EXPECT_EQ(large.type(), field::SampleType::f64);
  EXPECT_EQ(sparse_value<double>(sparse_of(large), {1, 2, 3}), 7);
  EXPECT_EQ(sparse_value<double>(sparse_of(large), {-100, 0, 9}), 0x1p53);
  EXPECT_TRUE(has_note(large, "beyond 2^53"));
}

TEST(OpenVdbVolume, ReadsVectorsByComponentAndLength) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  const openvdb::Vec3f v(3, 4, -12);
  write_vdb(folder / "v.vdb", {two_voxels<openvdb::Vec3SGrid>("velocity", v, {1, 0, 0}),
                               two_voxels<openvdb::Vec3IGrid>("count", {1, 2, 2}, {0, 0, 5})});
  const std::array<std::pair<std::string, double>, 4> parts{
      std::pair{"velocity[x]", 3.0}, {"velocity[y]", 4.0}, {"velocity[z]", -12.0}, {"velocity[length]", 13.0}};
  for (const auto& [name, value] : parts) {
    const field::ScalarField field = must_grid(folder / "v.vdb", name);
    EXPECT_EQ(field.type(), field::SampleType::f32);
    EXPECT_EQ(field.grid, name);
    EXPECT_EQ(sparse_value<float>(sparse_of(field), {1, 2, 3}), value) << name;
  }
  EXPECT_EQ(sparse_value<std::int32_t>(sparse_of(must_grid(folder / "v.vdb", "count[z]")), {-100, 0, 9}), 5);
  EXPECT_EQ(sparse_value<double>(sparse_of(must_grid(folder / "v.vdb", "count[length]")), {1, 2, 3}), 3);
  const auto whole = try_grid(folder / "v.vdb", "velocity");
  ASSERT_FALSE(whole);
  expect_in(test::text_of(whole.error().hint), "velocity[length]");
}

TEST(OpenVdbVolume, RequiresTheNameOfABoolGridBesideAFloatGrid) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "v.vdb",
            {two_voxels<openvdb::FloatGrid>("density", 1, 2), two_voxels<openvdb::BoolGrid>("flags", true, true)});
  EXPECT_EQ(must_grid(folder / "v.vdb").name, "density");
  EXPECT_EQ(must_grid(folder / "v.vdb", "flags").type(), field::SampleType::u8);
  EXPECT_FALSE(try_grid(folder / "v.vdb", "density[x]"));
}

TEST(OpenVdbVolume, ResamplesFrustums) {
  NEEDS_OPENVDB_PLUGIN();
  openvdb::initialize();
  // Voxels at the far plane are twice as large as at the near one.
  const auto transform =
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {40, 40, 40}), 0.5, 4, 0.1);
  const auto grid = openvdb::FloatGrid::create();
  grid->setName("v");
  grid->setTransform(transform);
  // Values are the world's z: interpolation reproduces linear functions up to the curvature within a voxel.
  for (const openvdb::Coord& at : openvdb::CoordBBox({0, 0, 0}, {40, 40, 40})) {
    grid->tree().setValue(at, static_cast<float>(transform->indexToWorld(at).z()));
  }
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {grid});
  const field::ScalarField field = must_grid(folder / "v.vdb");
  EXPECT_TRUE(has_note(field, "resamples it trilinearly to cubic voxels with a spacing of "));
  const double spacing = field.index_to_world.linear[0][0];
  const openvdb::Vec3d edges = transform->voxelSize({20, 20, 20});
  EXPECT_EQ(spacing, std::min({edges.x(), edges.y(), edges.z()}));
  int compared = 0;
  for (const openvdb::Coord& at : openvdb::CoordBBox({15, 15, 5}, {25, 25, 35})) {
    const openvdb::Vec3d world = transform->indexToWorld(at);
    const openvdb::Coord near = openvdb::Coord::round(world / spacing);
    const double value = sparse_value<float>(sparse_of(field), {near.x(), near.y(), near.z()});
    EXPECT_NEAR(value, near.z() * spacing, 1e-5) << at;
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(OpenVdbVolume, NamesTheMissingPlugin) {
  const TempFolder folder;
  const auto bent = two_voxels<openvdb::FloatGrid>("bent", 1, 2);
  bent->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {100, 100, 100}), 0.5, 10, 0.1));
  write_vdb(folder / "v.vdb", {bent, two_voxels<openvdb::Vec3SGrid>("velocity", {1, 0, 0}, {0, 1, 0})});
  const auto missing = volume_io::make_vdb_format({"/nowhere"});
  for (const std::string grid : {"bent", "velocity[x]"}) {
    volume_io::ReadOptions options;
    options.grid = grid;
    const auto field = missing->open((folder / "v.vdb").string(), options, Context());
    ASSERT_FALSE(field);
    EXPECT_EQ(field.error().code, ErrorCode::unavailable);
    expect_in(field.error().message, "isoextract-volume-openvdb.so, which is in none of the folders /nowhere");
    expect_in(field.error().message, grid == "bent" ? "'bent' lies in a frustum" : "'velocity' holds vec3s");
  }
  const auto listed = missing->list((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->size(), 2U);
}

TEST(OpenVdbVolume, ReservesAndReleasesMemory) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {two_voxels<openvdb::BoolGrid>("flags", true, true)});
  const auto refused = try_grid(folder / "v.vdb", "flags", with_memory(1000));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  const Context context;
  {
    const auto field = try_grid(folder / "v.vdb", "flags", context);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_GE(context.memory().reserved(), 2U * 512U);
    EXPECT_LE(context.memory().reserved(), 2U * 512U + 10000U);
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

// Each component holds its coordinate at the position where OpenVDB's staggered sampler expects it.
TEST(OpenVdbVolume, PlacesStaggeredComponentsOnVoxelFaces) {
  NEEDS_OPENVDB_PLUGIN();
  openvdb::initialize();
  const auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  velocity->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  velocity->setGridClass(openvdb::GRID_STAGGERED);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      for (int k = 0; k < 4; ++k) {
        const openvdb::Vec3d faces(i - 0.5, j - 0.5, k - 0.5);
        velocity->tree().setValue({i, j, k}, openvdb::Vec3f(velocity->indexToWorld(faces)));
      }
    }
  }
  const openvdb::Vec3f there = openvdb::tools::StaggeredBoxSampler::sample(velocity->tree(), {1.25, 1.5, 1.75});
  ASSERT_NEAR(there.x(), 0.625, 1e-6) << "as OpenVDB has it";
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {velocity});
  for (int axis = 0; axis < 3; ++axis) {
    const field::ScalarField part = must_grid(folder / "v.vdb", fmt::format("velocity[{}]", "xyz"[axis]));
    const auto value = sparse_value<float>(sparse_of(part), {1, 2, 3});
    EXPECT_NEAR(part.index_to_world({1, 2, 3})[axis], static_cast<double>(value), 1e-6);
    EXPECT_NEAR(part.index_to_world({1, 2, 3})[(axis + 1) % 3], 0.5 * (1 + (axis + 1) % 3), 1e-6);
    EXPECT_EQ(part.index_to_file({1, 2, 3})[axis], axis + 0.5);
    EXPECT_TRUE(has_note(part, "on the faces of voxels"));
  }
  EXPECT_TRUE(has_note(must_grid(folder / "v.vdb", "velocity[length]"), "half a voxel apart"));
}

TEST(OpenVdbVolume, RejectsTruncatedFiles) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {two_voxels<openvdb::Vec3SGrid>("velocity", {1, 2, 3}, {4, 5, 6})});
  const std::string whole = read_bytes(folder / "v.vdb");
  for (std::size_t cut = 0; cut < whole.size(); cut += 7) {
    write_bytes(folder / "cut.vdb", whole.substr(0, cut));
    const auto field = try_grid(folder / "cut.vdb", "velocity[x]");
    ASSERT_FALSE(field) << cut;
    EXPECT_EQ(field.error().code, ErrorCode::input) << cut;
    expect_in(field.error().message, "cut.vdb");
  }
}

}  // namespace
}  // namespace isoextract::test

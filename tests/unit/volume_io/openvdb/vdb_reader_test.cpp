#include <random>

#include "support/hints.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"
#include "volume_io/detail/formats.hpp"

namespace isoextract::test {
namespace {

// Makes blocks of noise, active and inactive tiles of all three sizes, and an inactive value in a leaf.
template <class Grid>
typename Grid::Ptr mixed_grid(typename Grid::ValueType background, unsigned seed = 1) {
  using Value = typename Grid::ValueType;
  auto grid = Grid::create(background);
  auto& tree = grid->tree();
  std::mt19937 engine(seed);
  std::uniform_int_distribution<int> index(-60, 60);
  std::uniform_int_distribution<int> value(-50, 50);
  auto accessor = grid->getAccessor();
  for (int n = 0; n < 1500; ++n) {
    accessor.setValue({index(engine), index(engine), index(engine)}, static_cast<Value>(value(engine)));
  }
  for (int n = 0; n < 20; ++n) {
    tree.addTile(1, {index(engine), index(engine), index(engine)}, static_cast<Value>(value(engine)), n % 2 == 0);
  }
  tree.addTile(2, {1000, -1000, 1000}, static_cast<Value>(7), true);
  tree.addTile(2, {-1000, 1000, 1000}, static_cast<Value>(8), false);
  tree.addTile(3, {5000, 5000, -5000}, static_cast<Value>(9), false);
  tree.addTile(3, {-9000, 5000, 5000}, static_cast<Value>(10), true);
  accessor.setValueOff({3, 4, 5}, static_cast<Value>(33));
  return grid;
}

template <class Grid>
void expect_same_values(const Grid& grid, const field::ScalarField& field) {
  using Value = typename Grid::ValueType;
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  ASSERT_EQ(samples.type, field::sample_type_of<Value>());
  EXPECT_EQ(samples.background, static_cast<double>(grid.background()));
  EXPECT_EQ(samples.blocks.size(), grid.tree().leafCount());
  EXPECT_EQ(samples.active_voxels, grid.activeVoxelCount());
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  EXPECT_EQ(samples.active_box, (field::IndexBox{{box.min().x(), box.min().y(), box.min().z()},
                                                 {box.max().x(), box.max().y(), box.max().z()}}));
  for (const field::SparseTile& tile : samples.tiles) EXPECT_NE(tile.value, samples.background);
  const auto accessor = grid.getConstAccessor();
  std::mt19937 engine(99);
  for (const int reach : {70, 1100, 10000}) {
    std::uniform_int_distribution<int> index(-reach, reach);
    for (int n = 0; n < 3000; ++n) {
      const openvdb::Coord ijk(index(engine), index(engine), index(engine));
      ASSERT_EQ(sparse_value<Value>(samples, {ijk.x(), ijk.y(), ijk.z()}), static_cast<double>(accessor.getValue(ijk)))
          << ijk;
    }
  }
  for (auto voxel = grid.cbeginValueOn(); voxel; ++voxel) {
    const openvdb::Coord ijk = voxel.getCoord();
    ASSERT_EQ(sparse_value<Value>(samples, {ijk.x(), ijk.y(), ijk.z()}), static_cast<double>(*voxel)) << ijk;
  }
}

template <class Grid>
class VdbReader : public testing::Test {};
using ScalarGrids = testing::Types<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid>;
TYPED_TEST_SUITE(VdbReader, ScalarGrids);

TYPED_TEST(VdbReader, ReadsEveryCompression) {
  using namespace openvdb::io;
  using Value = typename TypeParam::ValueType;
  for (const Value background : {Value(0), Value(5)}) {
    for (const std::uint32_t compression :
         {std::uint32_t{COMPRESS_NONE}, std::uint32_t{COMPRESS_ACTIVE_MASK}, std::uint32_t{COMPRESS_ZIP},
          std::uint32_t{COMPRESS_ZIP | COMPRESS_ACTIVE_MASK}, std::uint32_t{COMPRESS_BLOSC},
          std::uint32_t{COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK}}) {
      for (const bool half : {false, true}) {
        SCOPED_TRACE(testing::Message() << "compression " << compression << ", half " << half);
        const auto grid = mixed_grid<TypeParam>(background);
        grid->setSaveFloatAsHalf(half);  // the values are small integers: exact in half
        const TempFolder folder;
        write_vdb(folder / "v.vdb", {grid}, compression);
        expect_same_values(*grid, must_read(folder / "v.vdb"));
      }
    }
  }
}

TYPED_TEST(VdbReader, SortsBlocksAndOwnsTheirValues) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {mixed_grid<TypeParam>(0)});
  const field::ScalarField field = must_read(folder / "v.vdb");
  const auto& samples = std::get<field::SparseSamples>(field.samples);
  const auto key = [](const field::SparseBlock& b) { return std::tuple(b.origin.x, b.origin.y, b.origin.z); };
  for (std::size_t i = 0; i + 1 < samples.blocks.size(); ++i) {
    ASSERT_LT(key(samples.blocks[i]), key(samples.blocks[i + 1]));
  }
  // Only the samples own the values.
  EXPECT_EQ(samples.owner.use_count(), 1);
}

openvdb::FloatGrid::Ptr ball(const std::string& name, float radius = 10) {
  auto grid = openvdb::FloatGrid::create(3.0F);
  auto accessor = grid->getAccessor();
  for (int i = -12; i <= 12; ++i) {
    for (int j = -12; j <= 12; ++j) {
      for (int k = -12; k <= 12; ++k) {
        const float distance = std::sqrt(static_cast<float>(i * i + j * j + k * k)) - radius;
        if (std::abs(distance) < 3) accessor.setValue({i, j, k}, distance);
      }
    }
  }
  grid->setName(name);
  return grid;
}

TEST(VdbReaderKind, FollowsOptionsThenGridClass) {
  const TempFolder folder;
  const auto grid = ball("ls");
  const auto kind_of = [&](openvdb::GridClass grid_class, std::optional<field::FieldKind> kind = {}) {
    grid->setGridClass(grid_class);
    write_vdb(folder / "v.vdb", {grid});
    volume_io::ReadOptions options;
    options.kind = kind;
    return must_read(folder / "v.vdb", options).kind;
  };
  EXPECT_EQ(kind_of(openvdb::GRID_LEVEL_SET), field::FieldKind::level_set);
  EXPECT_EQ(kind_of(openvdb::GRID_FOG_VOLUME), field::FieldKind::density);
  EXPECT_EQ(kind_of(openvdb::GRID_UNKNOWN), field::FieldKind::density);
  EXPECT_EQ(kind_of(openvdb::GRID_LEVEL_SET, field::FieldKind::density), field::FieldKind::density);
  EXPECT_EQ(kind_of(openvdb::GRID_UNKNOWN, field::FieldKind::level_set), field::FieldKind::level_set);
  const auto grids = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(grids);
  EXPECT_FALSE(grids->front().kind);
}

TEST(VdbReaderPlace, ReadsRotationShearScaleTranslationAndMirror) {
  openvdb::initialize();
  const auto place = [](const openvdb::math::Transform::Ptr& transform) {
    const auto grid = ball("v");
    grid->setTransform(transform);
    const TempFolder folder;
    write_vdb(folder / "v.vdb", {grid});
    const field::ScalarField field = must_read(folder / "v.vdb");
    for (const glm::dvec3 p : {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(2, -3, 5)}) {
      const openvdb::Vec3d world = transform->indexToWorld(openvdb::Vec3d(p.x, p.y, p.z));
      expect_near(field.index_to_world(p), {world.x(), world.y(), world.z()});
    }
    return field.index_to_world;
  };
  using openvdb::math::Transform;
  place(Transform::createLinearTransform());
  place(Transform::createLinearTransform(0.25));
  const auto moved = Transform::createLinearTransform(0.5);
  moved->postTranslate({10, 20, 30});
  place(moved);
  const auto turned = Transform::createLinearTransform(0.5);
  turned->postRotate(0.3, openvdb::math::X_AXIS);
  turned->postShear(0.7, openvdb::math::X_AXIS, openvdb::math::Z_AXIS);
  turned->postScale({1, 2, -3});
  turned->postTranslate({-1e7, 3, 0.1});
  place(turned);

  // By hand: steps in x map to (0, 2, 0), in y to (-3, 0, 1), in z to (0, 0, 4), with the origin (5, 6, 7).
  const field::Affine affine =
      place(Transform::createLinearTransform(openvdb::Mat4d(0, 2, 0, 0, -3, 0, 1, 0, 0, 0, 4, 0, 5, 6, 7, 1)));
  expect_near(affine({1, 0, 0}), {5, 8, 7});
  expect_near(affine({0, 1, 0}), {2, 6, 8});
  expect_near(affine({0, 0, 1}), {5, 6, 11});
}

TEST(VdbReaderPlace, ReadsEveryLinearMap) {
  openvdb::initialize();
  using namespace openvdb::math;
  using openvdb::Vec3d;
  const std::vector<MapBase::Ptr> maps{
      std::make_shared<AffineMap>(openvdb::Mat4d(0, 2, 0, 0, -3, 0, 1, 0, 0, 0, 4, 0, 5, 6, 7, 1)),
      std::make_shared<UnitaryMap>(Vec3d(1, 2, 3), 0.4),
      std::make_shared<ScaleMap>(Vec3d(1, -2, 3)),
      std::make_shared<UniformScaleMap>(0.5),
      std::make_shared<TranslationMap>(Vec3d(4, 5, -6)),
      std::make_shared<ScaleTranslateMap>(Vec3d(1, 2, 3), Vec3d(4, 5, -6)),
      std::make_shared<UniformScaleTranslateMap>(0.25, Vec3d(4, 5, -6))};
  for (const auto& map : maps) {
    SCOPED_TRACE(map->type());
    const auto grid = ball("v");
    grid->setTransform(std::make_shared<Transform>(map));
    const TempFolder folder;
    write_vdb(folder / "v.vdb", {grid});
    const field::ScalarField field = must_read(folder / "v.vdb");
    for (const glm::dvec3 p : {glm::dvec3(0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(2, -3, 5)}) {
      const Vec3d world = map->applyMap(Vec3d(p.x, p.y, p.z));
      expect_near(field.index_to_world(p), {world.x(), world.y(), world.z()});
    }
    expect_same_values(*grid, field);
  }
}

TEST(VdbReaderPlace, NeedsThePluginForFrustumsWithoutPlacement) {
  openvdb::initialize();
  const auto grid = ball("v");
  grid->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {100, 100, 100}), 0.5, 10, 0.1));
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {grid});
  const auto refused = volume_io::make_vdb_format({"/nowhere"})->open((folder / "v.vdb").string(), {}, Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  expect_in(refused.error().message, "the grid 'v' lies in a frustum");
  volume_io::ReadOptions options;
  options.spacing = glm::dvec3(0.5);
  options.origin = glm::dvec3(1, 2, 3);
  const field::ScalarField field = must_read(folder / "v.vdb", options);
  EXPECT_TRUE(has_note(field, "NonlinearFrustumMap"));
  expect_near(field.index_to_world({2, 2, 2}), {2, 3, 4});
  expect_same_values(*grid, field);
}

// A file with a grid of each kind.
struct ManyGrids {
  TempFolder folder;
  std::filesystem::path path = folder / "many.vdb";

  ManyGrids() {
    openvdb::initialize();
    auto velocity = openvdb::Vec3SGrid::create();
    velocity->setName("velocity");
    velocity->tree().setValue({1, 2, 3}, openvdb::Vec3s(1, 2, 3));
    auto mask = openvdb::MaskGrid::create();
    mask->setName("mask");
    auto count = openvdb::Int64Grid::create();
    count->setName("count");
    auto flags = openvdb::Int32Grid::create();
    flags->setName("flags");
    auto level = ball("surface");
    level->setGridClass(openvdb::GRID_LEVEL_SET);
    const auto twin = ball("twin", 5);
    const auto other_twin = ball("twin", 6);
    const auto unnamed = ball("");
    write_vdb(path, {velocity, level, mask, count, flags, twin, other_twin, unnamed});
  }
};

TEST(VdbReaderGrids, ListTypesClassesCountsAndBoxes) {
  const ManyGrids file;
  const auto grids = volume_io::list_grids(file.path.string(), {}, Context());
  ASSERT_TRUE(grids);
  const auto find = [&](const std::string& label) {
    const auto found = std::ranges::find(*grids, label, &volume_io::GridInfo::label);
    if (found == grids->end()) throw std::runtime_error("no grid " + label);
    return *found;
  };
  EXPECT_EQ(grids->size(), 8U);
  EXPECT_EQ(find("velocity").type, "vec3s");
  EXPECT_FALSE(find("velocity").scalar);
  EXPECT_FALSE(find("mask").scalar);
  EXPECT_EQ(find("count").type, "int64");
  EXPECT_FALSE(find("count").scalar);
  EXPECT_TRUE(find("flags").scalar);
  EXPECT_EQ(find("flags").voxels, 0U);
  EXPECT_TRUE(find("flags").box.empty());
  EXPECT_EQ(find("surface").kind, field::FieldKind::level_set);
  EXPECT_EQ(find("surface").voxels, ball("")->activeVoxelCount());
  EXPECT_EQ(find("surface").box, (field::IndexBox{glm::ivec3(-12), glm::ivec3(12)}));
  EXPECT_EQ(find("twin[0]").name, "twin");
  EXPECT_EQ(find("twin[1]").voxels, ball("", 6)->activeVoxelCount());
}

TEST(VdbReaderGrids, RequireAChoiceAndListGrids) {
  const ManyGrids file;
  const Error error = refusal(file.path);
  EXPECT_EQ(error.code, ErrorCode::input);
  expect_in(error.message, "expected one scalar grid, found 5");
  EXPECT_TRUE(test::has_step(error.hint, Remedy::choose, Setting::grid));
  for (const char* line : {"\n  velocity  vec3s", "not scalar", "\n  flags", "empty", "\n  twin[0]", "\n  twin[1]",
                           "level set", "active voxels in [-12,-12,-12]..[12,12,12]"}) {
    expect_in(test::text_of(error.hint), line);
  }
}

TEST(VdbReaderGrids, FindNamesAndRepeatedNames) {
  const ManyGrids file;
  const auto voxels = [&](const std::string& grid) {
    volume_io::ReadOptions options;
    options.grid = grid;
    return std::get<field::SparseSamples>(must_read(file.path, options).samples).active_voxels;
  };
  EXPECT_EQ(voxels("surface"), ball("")->activeVoxelCount());
  EXPECT_EQ(voxels("twin[0]"), ball("", 5)->activeVoxelCount());
  EXPECT_EQ(voxels("twin[1]"), ball("", 6)->activeVoxelCount());
  EXPECT_EQ(voxels(""), ball("")->activeVoxelCount());
  const auto message = [&](const std::string& grid) {
    volume_io::ReadOptions options;
    options.grid = grid;
    const Error error = refusal(file.path, options);
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(test::text_of(error.hint), "\n  surface");
    return error.message;
  };
  expect_in(message("twin"), "2 grids are named 'twin'");
  expect_in(message("twin[2]"), "there is no grid 'twin[2]'");
  expect_in(message("densty"), "there is no grid 'densty'");
  volume_io::ReadOptions vectors;
  vectors.grid = "velocity";
  expect_in(refusal(file.path, vectors).message, "'velocity' holds vec3s");
}

TEST(VdbReaderGrids, ReadTheOnlyScalarGridAndNoteOthers) {
  openvdb::initialize();
  auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {velocity, ball("density")});
  const field::ScalarField field = must_read(folder / "v.vdb");
  EXPECT_EQ(field.name, "density");
  EXPECT_EQ(field.format, "OpenVDB");
  EXPECT_TRUE(has_note(field, "the reader takes grid 'density', the only scalar one of 2"));
  write_vdb(folder / "v.vdb", {ball("density")});
  EXPECT_TRUE(must_read(folder / "v.vdb").notes.empty());
  write_vdb(folder / "v.vdb", {velocity});
  expect_in(refusal(folder / "v.vdb").message, "'velocity' holds vec3s");
  write_vdb(folder / "v.vdb", {});
  expect_in(refusal(folder / "v.vdb").message, "no grid in the file");
}

TEST(VdbReaderGrids, CountActiveVoxelsIfTheFileDoesNot) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {ball("a"), ball("b", 5)}, openvdb::io::COMPRESS_BLOSC, false);
  const auto grids = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(grids);
  EXPECT_EQ(grids->at(0).voxels, ball("a")->activeVoxelCount());
  EXPECT_EQ(grids->at(1).voxels, ball("b", 5)->activeVoxelCount());
  EXPECT_EQ(grids->at(0).box, (field::IndexBox{glm::ivec3(-12), glm::ivec3(12)}));
  volume_io::ReadOptions options;
  options.grid = "b";
  expect_same_values(*ball("b", 5), must_read(folder / "v.vdb", options));
}

TEST(VdbReaderGrids, ShareATreeAmongInstances) {
  openvdb::initialize();
  const auto first = ball("first");
  const auto second = openvdb::FloatGrid::create(first->treePtr());
  second->setName("second");
  second->setTransform(openvdb::math::Transform::createLinearTransform(2));
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {first, second});
  volume_io::ReadOptions options;
  options.grid = "second";
  const field::ScalarField field = must_read(folder / "v.vdb", options);
  expect_same_values(*first, field);
  expect_near(field.index_to_world({1, 1, 1}), {2, 2, 2});
}

TEST(VdbReaderGrids, ReadEmptyGrids) {
  openvdb::initialize();
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {openvdb::FloatGrid::create(2)});
  const auto samples = std::get<field::SparseSamples>(must_read(folder / "v.vdb").samples);
  EXPECT_TRUE(samples.blocks.empty());
  EXPECT_TRUE(samples.tiles.empty());
  EXPECT_TRUE(samples.active_box.empty());
  EXPECT_EQ(samples.background, 2);
}

TEST(VdbReaderLimits, CheckMemoryBeforeFillingLeaves) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {ball("density")});
  const Error error = refusal(folder / "v.vdb", {}, with_memory(56 * 512 * sizeof(float)));
  expect_in(error.message, "the 56 leaf nodes of grid 'density' would take");
  EXPECT_EQ(error.hint, Hint(Remedy::raise, Setting::memory_limit));
}

TEST(VdbReaderLimits, ReserveMemoryWhileTheSamplesLive) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {ball("density")});
  const Context context;
  {
    const field::ScalarField field = must_read(folder / "v.vdb", {}, context);
    const auto& samples = std::get<field::SparseSamples>(field.samples);
    EXPECT_EQ(context.memory().reserved(), 56 * 512 * sizeof(float) +
                                               samples.blocks.capacity() * sizeof(field::SparseBlock) +
                                               samples.tiles.capacity() * sizeof(field::SparseTile));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

TEST(VdbReaderLimits, CanBeCancelled) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {ball("density")});
  const Context context;
  context.cancel();
  const auto field = volume_io::read_volume((folder / "v.vdb").string(), {}, context);
  ASSERT_FALSE(field);
  EXPECT_EQ(field.error().code, ErrorCode::cancelled);
}

TEST(VdbReaderLimits, RejectVoxelsTooFarOut) {
  openvdb::initialize();
  for (const openvdb::Coord far :
       {openvdb::Coord(1 << 30, 0, 0), openvdb::Coord(0, 0, std::numeric_limits<int>::min())}) {
    const auto grid = ball("v");
    grid->tree().setValue(far, 1.0F);
    const TempFolder folder;
    write_vdb(folder / "v.vdb", {grid});
    expect_in(refusal(folder / "v.vdb").message, "expected voxel indices from -2^29 to 2^29 - 1");
  }
}

}  // namespace
}  // namespace isoextract::test

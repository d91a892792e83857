// Tests the reader's tree against OpenVDB's own: every bit of every leaf and tile.
#include <bit>
#include <cstring>
#include <fstream>
#include <map>
#include <random>
#include <set>

#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <tbb/global_control.h>

#include "files/file_bytes.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

using openvdb::Coord;

glm::ivec3 to_glm(const Coord& c) { return {c.x(), c.y(), c.z()}; }

// Values that compression could corrupt: signed zeros, values that half cannot represent, NaN.
template <class Value>
Value odd_value(std::mt19937& engine) {
  if constexpr (std::is_integral_v<Value>) {
    return static_cast<Value>(engine());
  } else {
    switch (engine() % 12) {
      case 0: return -Value(0);
      case 1: return std::numeric_limits<Value>::infinity();
      case 2: return std::numeric_limits<Value>::quiet_NaN();
      case 3: return std::numeric_limits<Value>::denorm_min();
      default: return static_cast<Value>(static_cast<float>(engine()) / 1e8F - 20);
    }
  }
}

// Returns an inactive value that makes OpenVDB use `code`, for the background b: 0 b; 1 -b; 2 another; 3 -b and b; 4
// another and b; 5 two others; 6 more.
template <class Value>
Value inactive_value(int code, Value b, std::mt19937& engine) {
  const bool first = engine() % 2 == 0;
  switch (code) {
    case 0: return b;
    case 1: return -b;
    case 2: return b + 2;
    case 3: return first ? -b : b;
    case 4: return first ? b + 2 : b;
    case 5: return first ? b + 2 : b + 3;
    default: return static_cast<Value>(engine() % 50) / 2;
  }
}

// Makes for each code a leaf, a lower node of 16^3 leaves and an upper node of 32^3 lower nodes that OpenVDB stores
// with it. A random part of their entries is active, or none, or all. Half of them are at negative indices. Tiles of
// all sizes are included.
template <class Grid>
typename Grid::Ptr coded_grid(typename Grid::ValueType background, unsigned seed) {
  using Value = typename Grid::ValueType;
  std::mt19937 engine(seed);
  const auto grid = Grid::create(background);
  auto& tree = grid->tree();
  const auto fill_node = [&](const Coord& origin, unsigned level, int side, int step, int code, unsigned density) {
    for (int i = 0; i < side * side * side; ++i) {
      const Coord at = origin + Coord(i / (side * side) * step, i / side % side * step, i % side * step);
      const bool active = engine() % 8 < density;
      tree.addTile(level, at, active ? odd_value<Value>(engine) : inactive_value(code, background, engine), active);
    }
  };
  for (int code = 0; code <= 6; ++code) {
    const int side = code % 2 == 0 ? 1 : -1;
    const Coord corner(4096 * side * (code + 1), -4096 * code, 4096 * side);
    fill_node(corner, 2, 32, 128, code, 1);
    fill_node(corner + Coord(256, 512, 1024), 1, 16, 8, code, static_cast<unsigned>(code) % 3);
    for (const unsigned density : {0U, 3U, 8U}) {
      auto* leaf = tree.touchLeaf(corner + Coord(128 * static_cast<int>(density), 1280, 2560));
      for (openvdb::Index i = 0; i < 512; ++i) {
        const bool active = engine() % 8 < density;
        leaf->setValueOnly(i, active ? odd_value<Value>(engine) : inactive_value(code, background, engine));
        leaf->setActiveState(i, active);
      }
    }
  }
  tree.addTile(3, {-81920, 0, 4096}, background + 1, false);
  tree.addTile(3, {0, 40960, 4096}, background + 2, true);
  tree.addTile(3, {0, 0, -122880}, background, true);
  return grid;
}

// Returns the codes that OpenVDB would use for the nodes of one type.
template <class Node, class Tree>
std::set<int> codes_of(const Tree& tree) {
  std::vector<const Node*> nodes;
  tree.getNodes(nodes);
  std::set<int> codes;
  for (const Node* node : nodes) {
    std::vector<typename Node::ValueType> values(Node::NUM_VALUES);
    for (auto value = node->cbeginValueAll(); value; ++value) values[value.pos()] = *value;
    using Mask = openvdb::util::NodeMask<Node::LOG2DIM>;
    Mask children;
    for (auto child = node->cbeginChildOn(); child; ++child) children.setOn(child.pos());
    const openvdb::io::MaskCompress<typename Node::ValueType, Mask> packing(node->getValueMask(), children,
                                                                            values.data(), tree.background());
    codes.insert(packing.metadata);
  }
  return codes;
}

template <class Tree>
void expect_same_leaves(const Tree& tree, const field::SparseSamples& samples) {
  ASSERT_EQ(samples.blocks.size(), tree.leafCount());
  const auto key = [](const field::SparseBlock& b) { return std::tuple(b.origin.x, b.origin.y, b.origin.z); };
  for (std::size_t i = 0; i < samples.blocks.size(); ++i) {
    const field::SparseBlock& block = samples.blocks[i];
    if (i > 0) {
      ASSERT_LT(key(samples.blocks[i - 1]), key(block));
    }
    const auto* leaf = tree.probeConstLeaf({block.origin.x, block.origin.y, block.origin.z});
    ASSERT_NE(leaf, nullptr);
    ASSERT_EQ(to_glm(leaf->origin()), block.origin);
    ASSERT_EQ(std::memcmp(leaf->buffer().data(), block.values, 512 * sizeof(typename Tree::ValueType)), 0)
        << leaf->origin();
  }
}

template <class Tree>
void expect_same_tiles(const Tree& tree, const field::SparseSamples& samples) {
  // By origin: the size, and the bits of the value.
  using Tiles = std::map<std::tuple<int, int, int>, std::pair<int, std::uint64_t>>;
  Tiles expected;
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(Tree::DEPTH - 2);
  for (; tile; ++tile) {
    if (*tile == tree.background()) continue;
    const Coord origin = tile.getCoord();
    expected[{origin.x(), origin.y(), origin.z()}] = {tile.getBoundingBox().dim().x(),
                                                      std::bit_cast<std::uint64_t>(static_cast<double>(*tile))};
  }
  Tiles found;
  for (const field::SparseTile& one : samples.tiles) {
    found[{one.origin.x, one.origin.y, one.origin.z}] = {one.size, std::bit_cast<std::uint64_t>(one.value)};
  }
  EXPECT_EQ(found.size(), samples.tiles.size());
  EXPECT_TRUE(found == expected) << found.size() << " tiles, expected " << expected.size();
}

// Returns the tiles as OpenVDB reads them.
template <class Grid>
typename Grid::Ptr grid_of_file(const std::filesystem::path& path, const std::string& name) {
  openvdb::io::File file(path.string());
  file.open(false);
  return openvdb::gridPtrCast<Grid>(file.readGrid(name));
}

template <class Grid>
typename Grid::Ptr grid_of_stream(const std::filesystem::path& path, const std::string& name) {
  std::ifstream file(path, std::ios::binary);
  openvdb::io::Stream stream(file, false);
  for (const auto& grid : *stream.getGrids()) {
    if (grid->getName() == name) return openvdb::gridPtrCast<Grid>(grid);
  }
  throw std::runtime_error("no grid " + name);
}

// Reads the grid of that name with this reader.
template <class Grid>
void expect_same_tree(const typename Grid::Ptr& grid, const std::filesystem::path& path, const std::string& name) {
  volume_io::ReadOptions options;
  options.grid = name;
  const auto samples = std::get<field::SparseSamples>(must_read(path, options).samples);
  EXPECT_EQ(samples.type, field::sample_type_of<typename Grid::ValueType>());
  EXPECT_EQ(samples.background, static_cast<double>(grid->background()));
  EXPECT_EQ(samples.active_voxels, grid->activeVoxelCount());
  const openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
  EXPECT_EQ(samples.active_box, (field::IndexBox{to_glm(box.min()), to_glm(box.max())}));
  expect_same_leaves(grid->tree(), samples);
  expect_same_tiles(grid->tree(), samples);
}

template <class Grid>
void expect_same_tree(const std::filesystem::path& path, const std::string& name) {
  expect_same_tree<Grid>(grid_of_file<Grid>(path, name), path, name);
}

using namespace openvdb::io;
constexpr std::uint32_t kCompressions[] = {COMPRESS_NONE,
                                           COMPRESS_ACTIVE_MASK,
                                           COMPRESS_ZIP,
                                           COMPRESS_ZIP | COMPRESS_ACTIVE_MASK,
                                           COMPRESS_BLOSC,
                                           COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK,
                                           COMPRESS_ZIP | COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK};

template <class Grid>
class VdbTree : public testing::Test {};
using ScalarGrids = testing::Types<openvdb::FloatGrid, openvdb::DoubleGrid, openvdb::Int32Grid>;
TYPED_TEST_SUITE(VdbTree, ScalarGrids);

TYPED_TEST(VdbTree, ReadsEveryInactiveValueCodeAtEveryLevel) {
  using Value = typename TypeParam::ValueType;
  openvdb::initialize();
  const Value background = 7;
  const auto grid = coded_grid<TypeParam>(background, 1);
  using Upper = typename TypeParam::TreeType::RootNodeType::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  using Leaf = typename Lower::ChildNodeType;
  const std::set<int> all{0, 1, 2, 3, 4, 5, 6};
  EXPECT_EQ(codes_of<Leaf>(grid->tree()), all);
  EXPECT_EQ(codes_of<Lower>(grid->tree()), all);
  EXPECT_EQ(codes_of<Upper>(grid->tree()), all);

  for (const std::uint32_t compression : kCompressions) {
    for (const bool half : {false, true}) {
      SCOPED_TRACE(testing::Message() << "compression " << compression << ", half " << half);
      grid->setName("v");
      grid->setSaveFloatAsHalf(half);
      const TempFolder folder;
      write_vdb(folder / "v.vdb", {grid}, compression);
      expect_same_tree<TypeParam>(folder / "v.vdb", "v");
    }
  }
}

// Makes leaves and tiles of all sizes at random positions on both sides of zero.
template <class Grid>
typename Grid::Ptr random_grid(unsigned seed) {
  using Value = typename Grid::ValueType;
  std::mt19937 engine(seed);
  const auto grid = Grid::create(static_cast<Value>(seed % 3));
  const auto index = [&](int reach) { return static_cast<int>(engine() % static_cast<unsigned>(2 * reach)) - reach; };
  const auto place = [&](int reach) { return Coord(index(reach), index(reach), index(reach)); };
  for (int n = 0; n < 40; ++n) {
    const int reach = 1 << (5 + engine() % 9);
    const auto level = static_cast<unsigned>(1 + engine() % 3);
    grid->tree().addTile(level, place(reach), odd_value<Value>(engine), engine() % 2 == 0);
  }
  for (int n = 0; n < 60; ++n) {
    const Coord corner = place(1 << (5 + engine() % 9));
    for (int m = 0; m < 40; ++m) {
      const Coord at = corner + Coord(index(6), index(6), index(6));
      grid->tree().setValue(at, odd_value<Value>(engine));
      if (m % 3 == 0) grid->tree().setValueOff(at);
    }
  }
  return grid;
}

TYPED_TEST(VdbTree, ReadsRandomTopologies) {
  openvdb::initialize();
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    const auto grid = random_grid<TypeParam>(seed);
    grid->setName("v");
    grid->setSaveFloatAsHalf(seed % 2 == 0);
    const TempFolder folder;
    write_vdb(folder / "v.vdb", {grid}, kCompressions[seed % std::size(kCompressions)], seed % 4 < 2);
    expect_same_tree<TypeParam>(folder / "v.vdb", "v");
  }
}

// Runs OpenVDB's loops on one thread. Its library is not built with the thread sanitizer, which would report their
// synchronization as races.
tbb::global_control one_thread() { return {tbb::global_control::max_allowed_parallelism, 1}; }

template <class Grid>
typename Grid::Ptr ball(float radius, const openvdb::Vec3f& center) {
  const auto alone = one_thread();
  return openvdb::tools::createLevelSetSphere<Grid>(radius, center, 0.5F);
}

openvdb::FloatGrid::Ptr fog_of(const openvdb::FloatGrid& surface) {
  const auto alone = one_thread();
  auto fog = surface.deepCopy();
  openvdb::tools::sdfToFogVolume(*fog);
  return fog;
}

TEST(VdbTreeFiles, ReadLevelSetsFogsAndInstances) {
  openvdb::initialize();
  const auto surface = ball<openvdb::FloatGrid>(40, {3, -7, 1});
  surface->setName("surface");
  const auto fog = fog_of(*surface);
  fog->setName("fog");
  const auto precise = ball<openvdb::DoubleGrid>(20, {-100, 7, 1});
  precise->setName("precise");
  precise->setSaveFloatAsHalf(true);
  const auto instance = openvdb::FloatGrid::create(fog->treePtr());
  instance->setName("instance");
  const auto numbers = random_grid<openvdb::Int32Grid>(5);
  numbers->setName("numbers");
  for (const std::uint32_t compression : kCompressions) {
    SCOPED_TRACE(testing::Message() << "compression " << compression);
    const TempFolder folder;
    const auto path = folder / "v.vdb";
    write_vdb(path, {surface, fog, precise, instance, numbers}, compression);
    expect_same_tree<openvdb::FloatGrid>(path, "surface");
    expect_same_tree<openvdb::FloatGrid>(path, "fog");
    expect_same_tree<openvdb::FloatGrid>(path, "instance");
    expect_same_tree<openvdb::DoubleGrid>(path, "precise");
    expect_same_tree<openvdb::Int32Grid>(path, "numbers");
  }
}

// Makes a grid with leaves, tiles of all sizes and inactive values.
template <class Grid>
openvdb::GridBase::Ptr other_grid(const std::string& name, const typename Grid::ValueType& value, bool half) {
  const auto grid = Grid::create();
  grid->setName(name);
  grid->setSaveFloatAsHalf(half);
  for (int i = 0; i < 60; ++i) {
    grid->tree().setValueOn({i * 7 % 50, i * 11 % 40, -i}, value);
    if (i % 4 == 0) grid->tree().setValueOff({i * 7 % 50, i * 11 % 40, -i}, value);
  }
  for (const int level : {1, 2, 3}) {
    grid->tree().addTile(static_cast<unsigned>(level), {8192 * level, 0, -8192}, value, level % 2 == 0);
  }
  return grid;
}

// A stream has no grid positions: finding a grid means skipping all grids before it, of any type.
TYPED_TEST(VdbTree, ReadsStreamsPastGridsOfAllTypes) {
  openvdb::initialize();
  for (const std::uint32_t compression : kCompressions) {
    for (const bool half : {false, true}) {
      SCOPED_TRACE(testing::Message() << "compression " << compression << ", half " << half);
      const auto first = random_grid<TypeParam>(1);
      first->setName("first");
      const auto last = random_grid<TypeParam>(half ? 2 : 3);
      last->setName("last");
      last->setSaveFloatAsHalf(half);
      last->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
      const auto instance = TypeParam::create(last->treePtr());
      instance->setName("instance");
      instance->setSaveFloatAsHalf(half);
      const openvdb::GridCPtrVec grids{first,
                                       other_grid<openvdb::Vec3SGrid>("vec3s", openvdb::Vec3s(1, -2, 3), half),
                                       other_grid<openvdb::Vec3DGrid>("vec3d", openvdb::Vec3d(1, -2, 3), half),
                                       other_grid<openvdb::Vec3IGrid>("vec3i", openvdb::Vec3i(1, -2, 3), half),
                                       other_grid<openvdb::Int64Grid>("int64", 7, half),
                                       other_grid<openvdb::BoolGrid>("bool", true, half),
                                       other_grid<openvdb::MaskGrid>("mask", true, half),
                                       TypeParam::create(5),
                                       last,
                                       instance};
      const TempFolder folder;
      const auto path = folder / "v.vdb";
      write_vdb_stream(path, grids, compression, !half);
      const auto listed = volume_io::list_grids(path.string(), {}, Context());
      ASSERT_TRUE(listed) << listed.error().message;
      ASSERT_EQ(listed->size(), grids.size());
      for (std::size_t i = 0; i < grids.size(); ++i) EXPECT_EQ(listed->at(i).name, grids[i]->getName());
      EXPECT_EQ(listed->at(8).voxels, last->activeVoxelCount());
      for (const std::string name : {"first", "last", "instance"}) {
        expect_same_tree<TypeParam>(grid_of_stream<TypeParam>(path, name), path, name);
      }
      volume_io::ReadOptions options;
      options.grid = "last";
      expect_near(must_read(path, options).index_to_world({2, 4, 6}), {1, 2, 3});
    }
  }
}

TEST(VdbTreeFiles, StopAtATreeThatCannotBeSkippedInAStream) {
  openvdb::initialize();
  const auto good = ball<openvdb::FloatGrid>(12, {0, 0, 0});
  good->setName("good");
  const TempFolder folder;
  const auto write_strange = [&](const openvdb::GridCPtrVec& grids) {
    write_vdb_stream(folder / "v.vdb", grids);
    std::string bytes = read_bytes(folder / "v.vdb");
    bytes.replace(bytes.find("Tree_int64_5_4_3"), 16, "Tree_int65_5_4_3");
    write_bytes(folder / "v.vdb", bytes);
  };
  const auto strange = other_grid<openvdb::Int64Grid>("strange", 7, false);
  write_strange({strange, good});
  const Error error = refusal(folder / "v.vdb");
  expect_in(error.message,
            "is not supported: grid 'strange': the reader cannot find the end of a tree of the unknown type "
            "Tree_int65_5_4_3");
  expect_in(error.message, "the file is a stream without the positions of its grids");
  // The reader need not skip the last grid.
  write_strange({good, strange});
  expect_same_tree<openvdb::FloatGrid>(good, folder / "v.vdb", "good");
}

TEST(VdbTreeFiles, AreReadOnce) {
  openvdb::initialize();
  const auto surface = ball<openvdb::FloatGrid>(60, {0, 0, 0});
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {surface});
  const auto size = static_cast<double>(std::filesystem::file_size(folder / "v.vdb"));
  const Context context;
  must_read(folder / "v.vdb", {}, context);
  const auto read = static_cast<double>(context.counters().bytes_read);
  // Reads the start twice: to detect the format, and for the header.
  EXPECT_GT(size, 4e6);
  EXPECT_GE(read, size);
  EXPECT_LT(read, size + 1e6);
  EXPECT_NEAR(static_cast<double>(context.progress().done()), read, 1e4);
}

}  // namespace
}  // namespace isoextract::test

// Tests truncated, damaged and malicious VDB files: each gives an error or a grid, never a crash.
#include <random>

#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"

// teem leaks a few bytes on some errors.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libteem\n"; }

namespace isoextract::test {
namespace {

// Makes a small grid with leaves, tiles, two kinds of inactive values and noise that does not compress.
template <class Grid>
std::string small_file(std::uint32_t compression, bool half, const std::string& name = "v", bool stream = false) {
  using Value = typename Grid::ValueType;
  openvdb::initialize();
  auto grid = Grid::create(Value(3));
  std::mt19937 engine(7);
  auto accessor = grid->getAccessor();
  for (int n = 0; n < 700; ++n) {
    const openvdb::Coord ijk(static_cast<int>(engine() % 12), static_cast<int>(engine() % 12),
                             static_cast<int>(engine() % 12));
    accessor.setValue(ijk, static_cast<Value>(static_cast<float>(engine()) / 1e5F));
  }
  for (int i = 0; i < 12; ++i) accessor.setValueOff({i, 2, 2}, static_cast<Value>(i % 2));
  grid->tree().addTile(1, {64, 0, 0}, Value(5), true);
  grid->tree().addTile(3, {8192, 0, 0}, Value(6), false);
  grid->setName(name);
  grid->setSaveFloatAsHalf(half);
  grid->insertMeta("note", openvdb::StringMetadata("some text"));
  const TempFolder folder;
  if (stream) {
    const auto velocity = openvdb::Vec3SGrid::create();
    velocity->tree().setValue({1, 2, 3}, openvdb::Vec3s(1, 2, 3));
    velocity->tree().addTile(1, {64, 0, 0}, openvdb::Vec3s(4, 5, 6), true);
    velocity->setSaveFloatAsHalf(half);
    write_vdb_stream(folder / "v.vdb", {velocity, grid}, compression);
  } else {
    write_vdb(folder / "v.vdb", {grid}, compression);
  }
  return read_bytes(folder / "v.vdb");
}

// Reads the grid and touches every value, so that a memory checker would find a bad pointer.
void read_and_touch(const std::filesystem::path& path) {
  const Context context = with_memory(std::uint64_t{1} << 30);
  const auto field = volume_io::read_volume(path.string(), {}, context);
  static_cast<void>(volume_io::list_grids(path.string(), {}, context));
  if (!field) {
    EXPECT_NE(field.error().message.find(path.filename().string()), std::string::npos);
    return;
  }
  const auto& samples = std::get<field::SparseSamples>(field->samples);
  double sum = 0;
  visit_sample_type(samples.type, [&]<class T>(std::type_identity<T>) {
    for (const field::SparseBlock& block : samples.blocks) {
      ASSERT_EQ(block.origin & 7, glm::ivec3(0));
      for (int i = 0; i < 512; ++i) sum += static_cast<double>(static_cast<const T*>(block.values)[i]);
    }
  });
  static_cast<void>(sum);
}

struct Layout {
  std::uint32_t compression;
  bool half;
};
using namespace openvdb::io;
const std::vector<Layout> kLayouts{{COMPRESS_NONE, false}, {COMPRESS_ACTIVE_MASK, true},
                                   {COMPRESS_ZIP, false},  {COMPRESS_ZIP | COMPRESS_ACTIVE_MASK, true},
                                   {COMPRESS_BLOSC, true}, {COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK, false}};

TEST(VdbDamage, RejectsTruncations) {
  for (const Layout& layout : kLayouts) {
    const std::string good = small_file<openvdb::FloatGrid>(layout.compression, layout.half);
    const TempFolder folder;
    const std::size_t step = std::max<std::size_t>(1, good.size() / 60);
    for (std::size_t length = 1; length < good.size(); length += length < 700 ? 5 : step) {
      write_bytes(folder / "v.vdb", good.substr(0, length));
      const Error error = refusal(folder / "v.vdb");
      EXPECT_EQ(error.code, ErrorCode::input);
    }
    write_bytes(folder / "v.vdb", good.substr(0, good.size() - 1));
    refusal(folder / "v.vdb");
  }
}

// A stream can only be checked by reading it to the end.
TEST(VdbDamage, RejectsTruncatedStreams) {
  for (const Layout& layout : kLayouts) {
    const std::string good = small_file<openvdb::FloatGrid>(layout.compression, layout.half, "v", true);
    const TempFolder folder;
    write_bytes(folder / "v.vdb", good);
    must_read(folder / "v.vdb");
    const std::size_t step = std::max<std::size_t>(1, good.size() / 100);
    for (std::size_t length = 1; length < good.size(); length += length < 700 ? 5 : step) {
      write_bytes(folder / "v.vdb", good.substr(0, length));
      EXPECT_EQ(refusal(folder / "v.vdb").code, ErrorCode::input);
      EXPECT_FALSE(volume_io::list_grids((folder / "v.vdb").string(), {}, Context())) << length;
    }
    write_bytes(folder / "v.vdb", good.substr(0, good.size() - 1));
    expect_in(refusal(folder / "v.vdb").message, "the VDB file is damaged: expected");
  }
}

template <class Grid>
void flip_bits(unsigned seed, int count, bool stream = false) {
  testing::internal::CaptureStderr();
  for (const Layout& layout : kLayouts) {
    const std::string good = small_file<Grid>(layout.compression, layout.half, "v", stream);
    // Most flips go to the small part that is neither values nor long runs of zeros.
    const std::size_t head = 700;
    const std::size_t tail = std::min<std::size_t>(good.size() / 2, 3000);
    std::mt19937 engine(seed);
    const TempFolder folder;
    for (int n = 0; n < count; ++n) {
      std::string bytes = good;
      for (int flips = 1 + n % 3; flips > 0; --flips) {
        const std::size_t range = n % 4;
        const std::size_t at = range == 0   ? engine() % head
                               : range == 1 ? good.size() - 1 - engine() % tail
                                            : engine() % good.size();
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (engine() % 8)));
      }
      write_bytes(folder / "v.vdb", bytes);
      read_and_touch(folder / "v.vdb");
    }
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(VdbDamage, SurvivesFlippedBitsInFloats) { flip_bits<openvdb::FloatGrid>(1, 200); }
TEST(VdbDamage, SurvivesFlippedBitsInDoubles) { flip_bits<openvdb::DoubleGrid>(2, 60); }
TEST(VdbDamage, SurvivesFlippedBitsInIntegers) { flip_bits<openvdb::Int32Grid>(3, 60); }
TEST(VdbDamage, SurvivesFlippedBitsInStreams) { flip_bits<openvdb::FloatGrid>(4, 100, true); }

TEST(VdbDamage, SurvivesChangesOfEveryHeaderByte) {
  const std::string good = small_file<openvdb::FloatGrid>(COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK, false);
  const TempFolder folder;
  for (std::size_t at = 0; at < 600; ++at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    write_bytes(folder / "v.vdb", bytes);
    read_and_touch(folder / "v.vdb");
  }
}

// Replaces every 8 bytes that may be a chunk's size by sizes that would overflow a buffer.
TEST(VdbDamage, RejectsWrongChunkSizes) {
  for (const Layout& layout : kLayouts) {
    const std::string good = small_file<openvdb::FloatGrid>(layout.compression, layout.half);
    const TempFolder folder;
    std::vector<std::size_t> places;
    for (std::size_t at = good.find("Map"); at + 8 <= good.size(); ++at) {
      std::int64_t size = 0;
      std::memcpy(&size, good.data() + at, sizeof size);
      const bool plausible = size != 0 && std::abs(size) < (1 << 18) && (size & 0xff) != 0;
      if (plausible) places.push_back(at);
    }
    const std::size_t step = 1 + places.size() / 60;
    for (std::size_t i = 0; i < places.size(); i += step) {
      for (const std::int64_t size : {std::int64_t{-4096}, std::int64_t{-1}, std::int64_t{1} << 40,
                                      std::numeric_limits<std::int64_t>::min(), std::int64_t{17}}) {
        std::string bytes = good;
        put(bytes, places[i], size);
        write_bytes(folder / "v.vdb", bytes);
        read_and_touch(folder / "v.vdb");
      }
    }
  }
}

TEST(VdbDamage, RejectsMalformedFiles) {
  const std::string good = small_file<openvdb::FloatGrid>(COMPRESS_ACTIVE_MASK, false, "thegrid");
  const auto with = [&](std::size_t at, auto value) {
    std::string bytes = good;
    put(bytes, at, value);
    return bytes;
  };
  const std::size_t name = good.find("thegrid");  // in the grid's descriptor, after its length
  const std::size_t type = good.find("Tree_float_5_4_3");
  const std::size_t offsets = type + 16 + 4;
  const std::size_t map =
      good.find("UniformScaleMap") == std::string::npos ? good.find("Map") : good.find("UniformScaleMap");
  std::string unknown_type = good;
  unknown_type.replace(type, 10, "Tree_flort");
  std::string unknown_map = good;
  unknown_map[map] = 'X';
  expect_all_refused(
      "v.vdb",
      {{"empty file", "", "empty"},
       {"text", "this is some text\n", "not a VDB file"},
       {"magic only", good.substr(0, 8), "damaged"},
       {"old version", with(8, std::uint32_t{210}), "is not supported: expected file version 222 or later, found 210"},
       {"count of metadata", with(57, std::uint32_t{0xffffffff}), "damaged"},
       {"negative count of grids", with(61, std::int32_t{-1}), "expected 0 or more grids, the header states -1"},
       {"huge count of grids", with(61, std::int32_t{0x7fffffff}), "damaged"},
       {"length of the name", with(name - 4, std::uint32_t{0xffffffff}), "a name of 4294967295 bytes"},
       {"unknown type", unknown_type, "found none"},
       {"grid before the header", with(offsets, std::int64_t{8}), "its header states bytes 8 to"},
       {"grid behind the file", with(offsets + 16, std::int64_t{1} << 40), "to 1099511627776"},
       {"negative position", with(offsets, std::int64_t{-5}), "(end of the file), its header states bytes -5 to"},
       {"unknown transform", unknown_map, "is not supported: expected a linear transform, found 'X"},
       {"NaN in the transform", with(map + 15, std::nan("")), "transform with an inverse"},
       {"zero scale", with(map + 15, 0.0), "transform with an inverse"}});
}

// One leaf and one tile, uncompressed except for the masks, so that positions can be counted from the end of the file.
struct OneLeafFile {
  static std::string with_compression(std::uint32_t compression) {
    openvdb::initialize();
    const auto grid = openvdb::FloatGrid::create(3);
    grid->tree().setValue({1, 2, 3}, 8);
    grid->tree().addTile(3, {8192, 0, 0}, 6, false);
    const TempFolder folder;
    write_vdb(folder / "v.vdb", {grid}, compression);
    return read_bytes(folder / "v.vdb");
  }
  std::string bytes = with_compression(COMPRESS_ACTIVE_MASK);
  // From the end: the value, the code, the mask, then the leaf's mask in the topology. Each inner node has two masks, a
  // code and no value. Then follow the upper node's origin and the tile: an origin, a value and a flag.
  std::size_t code = bytes.size() - 5;
  std::size_t mask = code - 64;
  std::size_t lower = mask - 64 - 1 - 2 * 512;
  std::size_t upper = lower - 1 - 2 * 4096;
  std::size_t child = upper - 12;
  std::size_t tile = child - 17;
  // Positions of the grid, of its values and of its end.
  std::size_t offsets = bytes.find("Tree_float_5_4_3") + 16 + 4;
};

template <class Value>
std::string with(std::string bytes, std::size_t at, Value value) {
  put(bytes, at, value);
  return bytes;
}

TEST(VdbDamage, RejectsInconsistentTrees) {
  const OneLeafFile file;
  const auto& [good, code, mask, lower, upper, child, tile, offsets] = file;
  ASSERT_EQ(good.substr(code + 1), pack(8.0F));
  ASSERT_EQ(good.substr(tile, 17), pack(8192) + pack(0) + pack(0) + pack(6.0F) + '\0');

  const std::string packed = OneLeafFile::with_compression(COMPRESS_BLOSC);
  std::int64_t length = 0;  // size of the leaf's chunk, which ends the file
  std::size_t chunk = packed.size() - 16;
  while (std::memcpy(&length, &packed[chunk - 8], 8), length != static_cast<std::int64_t>(packed.size() - chunk))
    --chunk;

  expect_all_refused(
      "v.vdb",
      {{"buffers", with(good, tile - 16, 2), "expected one buffer in a tree, found 2"},
       {"a tile where the node is", with(good, tile, 0),
        "expected one node or tile at each position, found two at (0, 0, 0)"},
       {"a tile's flag", with(good, tile + 16, '\2'), "expected 0 or 1 as the active flag of a tile, found 2"},
       {"a tile off the grid", with(good, tile, 8192 + 8), "multiples of 4096 voxels, found one at index 8200"},
       {"a node off the grid", with(good, child + 4, 128),
        "multiples of 4096 voxels, found one at index 128 along axis 1"},
       {"a node too far out", with(good, child + 8, 1 << 30), "expected voxel indices from -2^29 to 2^29 - 1"},
       {"an active tile of the background too far out",
        with(with(with(good, tile, 1 << 30), tile + 12, 3.0F), tile + 16, '\1'),
        "expected voxel indices from -2^29 to 2^29 - 1"},
       {"leaves past the grid's end", with(good, offsets + 16, static_cast<std::int64_t>(good.size() - 1)),
        "the grid has 3"},
       {"nodes past the grid's end", with(good, offsets + 16, static_cast<std::int64_t>(lower)), "the grid has"},
       {"code of a node", with(good, lower + 1024, '\7'), "found 7"},
       {"code of a leaf", with(good, code, '\x80'), "found 128"},
       {"other mask of a leaf", with(good, mask, '\1'), "differs from its mask"},
       {"chunk too long", with(packed, chunk - 8, std::int64_t{2} * 2048 + 513),
        "expected at most 4608 compressed bytes"},
       {"plain chunk too short", with(packed, chunk - 8, std::int64_t{-2047}),
        "expected 2048 bytes of uncompressed values"},
       {"blosc: other size", with(packed, chunk + 4, 2044),
        "expected a valid blosc chunk that decompresses to 2048 bytes"},
       {"blosc: other length", with(packed, chunk + 12, 20),
        "expected a valid blosc chunk that decompresses to 2048 bytes"},
       {"blosc: blocks too large", with(packed, chunk + 8, 1 << 30), "blosc chunk"}});
}

TEST(VdbDamage, RejectsUnsortedRootNodes) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create(3);
  grid->tree().setValue({0, 0, 0}, 8);
  grid->tree().setValue({0, 4096, 0}, 9);
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {grid});
  std::string bytes = read_bytes(folder / "v.vdb");
  const std::size_t second = bytes.rfind(pack(0) + pack(4096) + pack(0));
  // Moves the first node after the second: to (0, 8192, 0).
  const std::size_t place = second - (12 + 2 * 4096 + 1 + 2 * 512 + 1 + 64);
  ASSERT_EQ(bytes.substr(place, 12), std::string(12, '\0'));
  must_read(folder / "v.vdb");
  put(bytes, place + 4, 8192);
  write_bytes(folder / "v.vdb", bytes);
  expect_in(refusal(folder / "v.vdb").message,
            "expected nodes in the order of their positions, found (0, 4096, 0) after (0, 8192, 0)");
}

TEST(VdbDamage, RejectsMetadataPastTheEndOfTheGrid) {
  const OneLeafFile file;
  std::int64_t grid = 0;
  std::memcpy(&grid, &file.bytes[file.offsets], sizeof grid);
  expect_all_refused("v.vdb", {{"in an entry", with(file.bytes, file.offsets + 16, grid + 20), "left in the grid"},
                               {"before it", with(file.bytes, file.offsets + 16, grid + 6), "the grid has 2"}});
  // Points at the size of a skipped entry, after the count, its name and its type.
  std::string jump = file.bytes;
  const std::size_t size = jump.find("int64", static_cast<std::size_t>(grid)) + 5;
  put(jump, size, std::uint32_t{300});
  put(jump, file.offsets + 16, static_cast<std::int64_t>(size + 100));
  expect_all_refused("v.vdb", {{"passed over", jump, "beyond the end of the grid at byte"}});
}

// One byte of the header tells whether the file has grid positions; a stream's placeholders must be ignored.
TEST(VdbDamage, IgnoresGridPositionsOfAStream) {
  const OneLeafFile file;
  std::string stream = with(file.bytes, 20, char{0});
  for (std::size_t at = file.offsets; at < file.offsets + 24; at += 8) put(stream, at, std::int64_t{-1});
  const TempFolder folder;
  write_bytes(folder / "v.vdb", stream);
  const auto samples = std::get<field::SparseSamples>(must_read(folder / "v.vdb").samples);
  EXPECT_EQ(sparse_value<float>(samples, {1, 2, 3}), 8);
  expect_all_refused("v.vdb",
                     {{"buffers", with(stream, file.tile - 16, 2), "expected one buffer in a tree, found 2"},
                      {"code of a leaf", with(stream, file.code, '\x80'), "found 128"},
                      {"children", with(stream, file.tile - 4, 1000), "is damaged: "},
                      {"tiles", with(stream, file.tile - 8, 0x7fffffff), "is damaged: a file offset points to byte"}});
}

TEST(VdbDamage, DetectsHalvesByMetadataOnly) {
  OneLeafFile file;
  file.bytes.insert(file.offsets - 4, "_HalfFloat");
  put(file.bytes, file.offsets - 4 - 16 - 4, std::uint32_t{26});
  for (std::size_t at = file.offsets + 10; at < file.offsets + 34; at += 8) {
    std::int64_t position = 0;
    std::memcpy(&position, &file.bytes[at], sizeof position);
    put(file.bytes, at, position + 10);
  }
  const TempFolder folder;
  write_bytes(folder / "v.vdb", file.bytes);
  const auto samples = std::get<field::SparseSamples>(must_read(folder / "v.vdb").samples);
  EXPECT_EQ(sparse_value<float>(samples, {1, 2, 3}), 8);
}

// OpenVDB 3.0 wrote such files. A value is stored for the entry, but the entry is a child.
TEST(VdbDamage, ReadsActiveEntriesThatAreChildren) {
  const OneLeafFile file;
  const auto with_value = [&](std::size_t value_mask, std::size_t node_code) {
    std::string bytes = with(file.bytes, value_mask, '\1');
    bytes.insert(node_code + 1, pack(77.0F));
    return with(bytes, file.offsets + 16, static_cast<std::int64_t>(bytes.size()));
  };
  for (const std::string& bytes :
       {with_value(file.upper + 4096, file.upper + 8192), with_value(file.lower + 512, file.lower + 1024)}) {
    const TempFolder folder;
    write_bytes(folder / "v.vdb", bytes);
    const auto samples = std::get<field::SparseSamples>(must_read(folder / "v.vdb").samples);
    EXPECT_EQ(samples.active_voxels, 1U);
    EXPECT_EQ(samples.active_box, (field::IndexBox{{1, 2, 3}, {1, 2, 3}}));
    ASSERT_EQ(samples.tiles.size(), 1U);
    EXPECT_EQ(samples.tiles.front().value, 6);
    openvdb::io::File reference((folder / "v.vdb").string());
    reference.open(false);
    const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(reference.readGrid(reference.beginName().gridName()));
    for (const openvdb::Coord& at : {openvdb::Coord(1, 2, 3), openvdb::Coord(0, 0, 0), openvdb::Coord(8, 0, 0)}) {
      EXPECT_EQ(sparse_value<float>(samples, {at.x(), at.y(), at.z()}), grid->tree().getValue(at)) << at;
    }
  }
}

TEST(VdbDamage, RejectsUnknownCompressionsAndNotesNewerVersions) {
  std::string bytes = small_file<openvdb::FloatGrid>(COMPRESS_ACTIVE_MASK, false, "thegrid");
  const TempFolder folder;
  put(bytes, 8, std::uint32_t{225});
  write_bytes(folder / "v.vdb", bytes);
  EXPECT_TRUE(has_note(must_read(folder / "v.vdb"), "the file's version 225 is newer than 224"));
  std::int64_t grid = 0;
  std::memcpy(&grid, &bytes[bytes.find("Tree_float_5_4_3") + 16 + 4], sizeof grid);
  put(bytes, static_cast<std::size_t>(grid), std::uint32_t{8 | COMPRESS_ACTIVE_MASK});
  write_bytes(folder / "v.vdb", bytes);
  expect_in(refusal(folder / "v.vdb").message, "grid 'thegrid' is compressed in an unknown way (10)");
}

}  // namespace
}  // namespace isoextract::test

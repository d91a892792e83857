// Tests points read by the OpenVDB plug-in if it was built, and the messages without it.
#include <array>
#include <cstring>
#include <random>
#include <set>

#include <openvdb/points/PointConversion.h>

#include "particle_io/detail/plugin_particles.hpp"
#include "unit/particle_io/particle_files.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

#define NEEDS_OPENVDB_PLUGIN() \
  if (!BUILT_OPENVDB) GTEST_SKIP() << "the plug-ins around OpenVDB were not built"

const particle_io::ParticleFormat& points_with_plugin() {
  static const auto formats = particle_io::find_particle_plugins({std::filesystem::path(BUILT_PLUGINS)});
  return *formats[1];
}

Result<particle_io::ParticleFile> try_points(const std::filesystem::path& path,
                                             const particle_io::ParticleReadOptions& options = {},
                                             const particle_io::ParticleFormat& format = points_with_plugin()) {
  try {
    return format.read(particle_io::must(files::InputFile::open(path, Context())), options);
  } catch (const particle_io::InvalidParticleFile& damaged) {
    return fail(ErrorCode::input, damaged.what(), damaged.hint);
  } catch (const particle_io::Refused& refused) {
    return tl::unexpected(refused.error);
  }
}

// Returns points at `places` with attributes of several types.
openvdb::points::PointDataGrid::Ptr point_grid(const std::string& name, const std::vector<openvdb::Vec3d>& places,
                                               double voxel) {
  namespace points = openvdb::points;
  openvdb::initialize();
  const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  transform->postTranslate({10, 20, 30});
  const points::PointAttributeVector<openvdb::Vec3d> list(places);
  const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(list, *transform);
  const auto grid = points::createPointDataGrid<points::NullCodec, points::PointDataGrid>(*index, list, *transform);
  grid->setName(name);
  const auto add = [&]<class Value>(const std::string& attribute, const std::vector<Value>& values) {
    points::appendAttribute<Value>(grid->tree(), attribute);
    points::populateAttribute(grid->tree(), index->tree(), attribute, points::PointAttributeVector<Value>(values));
  };
  std::vector<float> heat;
  std::vector<std::int32_t> id;
  std::vector<openvdb::Vec3f> velocity;
  for (std::size_t i = 0; i < places.size(); ++i) {
    heat.push_back(0.5F * static_cast<float>(i));
    id.push_back(static_cast<std::int32_t>(70 + i));
    velocity.emplace_back(static_cast<float>(i), -1.0F, 0.25F);
  }
  add("heat", heat);
  add("id", id);
  add("velocity", velocity);
  return grid;
}

std::vector<openvdb::Vec3d> some_places() {
  std::vector<openvdb::Vec3d> places;
  for (int i = 0; i < 50; ++i) places.emplace_back(10 + 0.25 * i, 20 + 0.125 * (i * i % 40), 30 - 0.5 * (i % 7));
  return places;
}

TEST(OpenVdbPoints, ReadsPositionsAndAttributes) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  const auto places = some_places();
  write_vdb(folder / "p.vdb", {point_grid("drops", places, 0.5)});
  const auto read = try_points(folder / "p.vdb", with_all());
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->particles.size(), places.size());
  const auto& id = attribute_named(read->particles, "id").values;
  const auto& velocity = attribute_named(read->particles, "velocity");
  EXPECT_EQ(velocity.components, 3U);
  std::set<int> seen;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const int which = static_cast<int>(id[i]) - 70;
    seen.insert(which);
    const openvdb::Vec3d& place = places.at(static_cast<std::size_t>(which));
    expect_near(read->particles.positions[i], {place.x(), place.y(), place.z()}, 1e-7);
    EXPECT_EQ(attribute_named(read->particles, "heat").values[i], 0.5F * static_cast<float>(which));
    EXPECT_EQ(velocity.values[3 * i], static_cast<float>(which));
    EXPECT_EQ(velocity.values[3 * i + 2], 0.25F);
  }
  EXPECT_EQ(seen.size(), places.size());
}

// Blender's liquid caches store flags as truncated integers.
TEST(OpenVdbPoints, ReadsTruncatedIntegers) {
  NEEDS_OPENVDB_PLUGIN();
  namespace points = openvdb::points;
  using Truncated = points::TypedAttributeArray<std::int32_t, points::TruncateCodec>;
  const TempFolder folder;
  const auto places = some_places();
  const auto grid = point_grid("drops", places, 0.5);
  Truncated::registerType();
  points::appendAttribute<std::int32_t, points::TruncateCodec>(grid->tree(), "flags", -3);
  for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) {
    points::AttributeWriteHandle<std::int32_t> flags(leaf->attributeArray("flags"));
    const points::AttributeHandle<std::int32_t> id(leaf->constAttributeArray("id"));
    for (openvdb::Index i = 0; i < id.size(); ++i) flags.set(i, id.get(i) - 100);
  }
  write_vdb(folder / "p.vdb", {grid});
  Truncated::unregisterType();  // as in a process that reads the file
  const auto read = try_points(folder / "p.vdb", with_all());
  ASSERT_TRUE(read) << read.error().message;
  const auto& id = attribute_named(read->particles, "id").values;
  const auto& flags = attribute_named(read->particles, "flags").values;
  ASSERT_EQ(flags.size(), places.size());
  for (std::size_t i = 0; i < flags.size(); ++i) EXPECT_EQ(flags[i], id[i] - 100);
}

TEST(OpenVdbPoints, OffersThePositionAsAttribute) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  particle_io::ParticleReadOptions options;
  options.attributes = {"position", "heat"};
  const auto read = try_points(folder / "p.vdb", options);
  ASSERT_TRUE(read) << read.error().message;
  const auto& position = attribute_named(read->particles, "position");
  ASSERT_EQ(position.components, 3U);
  for (std::size_t i = 0; i < read->particles.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(position.values[3 * i + static_cast<std::size_t>(axis)],
                static_cast<float>(read->particles.positions[i][axis]));
    }
  }
  EXPECT_EQ(attribute_named(read->particles, "heat").components, 1U);
}

TEST(OpenVdbPoints, RejectsAttributesWithFewerPoints) {
  NEEDS_OPENVDB_PLUGIN();
  namespace points = openvdb::points;
  const TempFolder folder;
  const auto grid = point_grid("drops", some_places(), 0.5);
  for (auto leaf = grid->tree().beginLeaf(); leaf; ++leaf) {
    const auto& old = leaf->constAttributeArray("heat");
    if (old.size() < 2) continue;
    points::AttributeSet set(leaf->attributeSet(), old.size());
    set.replace("heat", points::TypedAttributeArray<float>::create(old.size() - 1, 1, true));
    leaf->replaceAttributeSet(new points::AttributeSet(set), true);
  }
  write_vdb(folder / "p.vdb", {grid});
  particle_io::ParticleReadOptions options;
  options.attributes = {"heat"};
  const auto read = try_points(folder / "p.vdb", options);
  ASSERT_FALSE(read);
  expect_in(read.error().message, "the file is damaged: expected a value of 'heat' for each point");
  EXPECT_TRUE(try_points(folder / "p.vdb"));
}

// Finds the arrays with `bytes_per_point` bytes for each point of a leaf: returns the positions of their size fields,
// which are 6 larger.
std::vector<std::size_t> places_of_arrays(const std::string& file, std::uint64_t bytes_per_point) {
  std::vector<std::size_t> places;
  for (std::size_t at = 0; at + 14 <= file.size(); ++at) {
    std::uint64_t bytes = 0;
    std::uint32_t points = 0;
    std::memcpy(&bytes, &file[at], sizeof(bytes));
    std::memcpy(&points, &file[at + 10], sizeof(points));
    if (points > 2 && points < 1000 && bytes == bytes_per_point * points + 6 && file[at + 8] == 8) places.push_back(at);
  }
  return places;
}

TEST(OpenVdbPoints, RejectsArraysWithTooFewBytes) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  std::string file = read_bytes(folder / "p.vdb");
  const auto arrays = places_of_arrays(file, 12);  // positions and velocities
  ASSERT_GE(arrays.size(), 2U);
  // Moves bytes from one array to the next, so that their total size stays the same.
  const auto add = [&](std::size_t at, std::int64_t more) {
    std::int64_t bytes = 0;
    std::memcpy(&bytes, &file[at], sizeof(bytes));
    bytes += more;
    std::memcpy(&file[at], &bytes, sizeof(bytes));
  };
  add(arrays[0], -24);
  add(arrays[1], 24);
  write_bytes(folder / "p.vdb", file);
  const auto read = try_points(folder / "p.vdb", with_all());
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::input);
  expect_in(read.error().message, "the file is damaged: expected ");
}

TEST(OpenVdbPoints, SurvivesDamagedFiles) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  const std::string whole = read_bytes(folder / "p.vdb");
  std::minstd_rand random(1);
  const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random()) % end; };
  constexpr std::array<std::uint32_t, 5> kWords{0, ~0U, 0x7fffffff, 0x80000000, 1};
  int refused = 0;
  for (int i = 0; i < 200; ++i) {
    std::string damaged = whole;
    for (std::size_t times = 1 + below(3); times > 0; --times) {
      if (below(2) == 0) {
        damaged[below(damaged.size())] ^= static_cast<char>(1U << below(8));
      } else {
        std::memcpy(&damaged[below(damaged.size() - 4)], &kWords.at(below(kWords.size())), 4);
      }
    }
    write_bytes(folder / "d.vdb", damaged);
    const auto read = try_points(folder / "d.vdb", with_all());
    if (read) continue;
    ++refused;
    // A damaged count may request more memory than exists.
    EXPECT_EQ(exit_code_of(read.error().code), exit_code_of(ErrorCode::input)) << i << ": " << read.error().message;
  }
  EXPECT_GT(refused, 10);
}

TEST(OpenVdbPoints, DetectsFilesWithOnlyPoints) {
  const TempFolder folder;
  const auto drops = point_grid("drops", some_places(), 0.5);
  write_vdb(folder / "points.vdb", {drops});
  write_vdb_stream(folder / "piped.vdb", {drops});
  write_vdb(folder / "both.vdb", {drops, two_voxels<openvdb::FloatGrid>("density", 1, 2)});
  const auto kind = [&](const std::string& name, const std::string& grid = "") {
    particle_io::ParticleReadOptions options;
    if (!grid.empty()) options.grid = grid;
    const auto found = particle_io::detect_particles((folder / name).string(), options, Context());
    return found && *found ? (*found)->id : "none";
  };
  EXPECT_EQ(kind("points.vdb"), "openvdb");
  EXPECT_EQ(kind("piped.vdb"), "openvdb");
  EXPECT_EQ(kind("both.vdb"), "none");
  EXPECT_EQ(kind("both.vdb", "drops"), "openvdb");
  EXPECT_EQ(kind("both.vdb", "density"), "none");
  // The rule for names is that of volumes: labels, and names as paths.
  EXPECT_EQ(kind("both.vdb", "/drops"), "openvdb");
  write_vdb(folder / "several.vdb", {drops, two_voxels<openvdb::FloatGrid>("density", 1, 2), drops->copy()});
  EXPECT_EQ(kind("several.vdb", "drops[1]"), "openvdb");
  EXPECT_EQ(kind("several.vdb", "drops[2]"), "none");
  particle_io::ParticleReadOptions options;
  options.grid = "drops";
  const auto several = particle_io::detect_particles((folder / "several.vdb").string(), options, Context());
  ASSERT_FALSE(several);
  EXPECT_EQ(several.error().code, ErrorCode::input);
  expect_in(several.error().message, "several.vdb: 2 grids are named 'drops'");
  ASSERT_FALSE(several.error().hint.steps.empty());
  expect_in(several.error().hint.steps.front().text, "drops[1]");
  const auto formats = particle_io::find_particle_plugins({"/nowhere"});
  const auto missing = try_points(folder / "points.vdb", {}, *formats[1]);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::unavailable);
  expect_in(missing.error().message, "isoextract-particles-openvdb.so");
}

TEST(OpenVdbPoints, SelectsAGridByName) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  auto few = some_places();
  few.resize(3);
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5), point_grid("foam", few, 0.5),
                               two_voxels<openvdb::FloatGrid>("density", 1, 2)});
  particle_io::ParticleReadOptions options;
  options.grid = "foam";
  const auto foam = try_points(folder / "p.vdb", options);
  ASSERT_TRUE(foam) << foam.error().message;
  EXPECT_EQ(foam->particles.size(), 3U);
  const auto unnamed = try_points(folder / "p.vdb");
  ASSERT_FALSE(unnamed);
  expect_in(unnamed.error().message, "expected the name of one of the grids of points: 'drops', 'foam'");
  options.grid = "density";
  expect_in(try_points(folder / "p.vdb", options).error().message, "there is no grid of points 'density'");
}

TEST(OpenVdbPoints, SelectsAGridByLabelAndPath) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  auto few = some_places();
  few.resize(3);
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5), point_grid("drops", few, 0.5),
                               point_grid("foam", {few.front()}, 0.5)});
  particle_io::ParticleReadOptions options;
  for (const auto& [name, count] : {std::pair("drops[0]", 50), {"drops[1]", 3}, {"foam", 1}, {"/foam", 1}}) {
    options.grid = name;
    const auto read = try_points(folder / "p.vdb", options);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->particles.size(), static_cast<std::size_t>(count)) << name;
  }
  for (const std::string& name : {std::string("drops"), std::string("/drops")}) {
    options.grid = name;
    expect_in(try_points(folder / "p.vdb", options).error().message, "2 grids are named '" + name + "'");
  }
}

TEST(OpenVdbPoints, RejectsTruncatedFiles) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  const std::string whole = read_bytes(folder / "p.vdb");
  for (std::size_t cut = 0; cut < whole.size(); cut += 11) {
    write_bytes(folder / "cut.vdb", whole.substr(0, cut));
    const auto read = try_points(folder / "cut.vdb");
    ASSERT_FALSE(read) << cut;
    EXPECT_EQ(read.error().code, ErrorCode::input) << cut;
  }
}

}  // namespace
}  // namespace isoextract::test

// Volumes and points by the plug-ins around OpenVDB, where they were built, and what is said where they are missing.
#include <array>
#include <cstring>
#include <random>
#include <set>

#include <openvdb/points/PointConversion.h>
#include <openvdb/tools/Interpolation.h>

#include "unit/volumes/particle_files.hpp"
#include "unit/volumes/vdb_files.hpp"
#include "unit/volumes/volume_files.hpp"
#include "volumes/detail/formats.hpp"
#include "volumes/particles/plugin_particles.hpp"

namespace isoextract::test {
namespace {

#define NEEDS_OPENVDB_PLUGIN() \
  if (!BUILT_OPENVDB) GTEST_SKIP() << "the plug-ins around OpenVDB were not built"

const volumes::VolumeFormat& vdb_with_plugin() {
  static const auto format = volumes::make_vdb_format({std::filesystem::path(BUILT_PLUGINS)});
  return *format;
}

const volumes::ParticleFormat& points_with_plugin() {
  static const auto formats = volumes::find_particle_plugins({std::filesystem::path(BUILT_PLUGINS)});
  return *formats[1];
}

Result<field::ScalarField> try_grid(const std::filesystem::path& path, const std::string& grid = "",
                                    const Context& context = Context()) {
  volumes::ReadOptions options;
  if (!grid.empty()) options.grid = grid;
  return vdb_with_plugin().open(path.string(), options, context);
}

field::ScalarField must_grid(const std::filesystem::path& path, const std::string& grid = "") {
  auto field = try_grid(path, grid);
  if (!field) throw std::runtime_error(field.error().message + "\n" + field.error().hint.text);
  return std::move(*field);
}

Result<volumes::ParticleFile> try_points(const std::filesystem::path& path,
                                         const volumes::ParticleReadOptions& options = {},
                                         const volumes::ParticleFormat& format = points_with_plugin()) {
  try {
    return format.read(volumes::must(files::InputFile::open(path, Context())), options);
  } catch (const volumes::DamagedParticles& damaged) {
    return fail(ErrorCode::input, damaged.what(), damaged.hint);
  } catch (const volumes::Refused& refused) {
    return tl::unexpected(refused.error);
  }
}

const auto& sparse_of(const field::ScalarField& field) { return std::get<field::SparseSamples>(field.samples); }

template <class Grid>
typename Grid::Ptr two_voxels(const std::string& name, typename Grid::ValueType first,
                              typename Grid::ValueType second) {
  openvdb::initialize();
  auto grid = Grid::create();
  grid->setName(name);
  grid->tree().setValue({1, 2, 3}, first);
  grid->tree().setValue({-100, 0, 9}, second);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  return grid;
}

TEST(OpenVdbVolume, BoolsMasksAndLargeIntegers) {
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

TEST(OpenVdbVolume, VectorsByComponentAndLength) {
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
  expect_in(whole.error().hint.text, "velocity[length]");
}

TEST(OpenVdbVolume, ABoolGridBesideAFloatNeedsItsName) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "v.vdb",
            {two_voxels<openvdb::FloatGrid>("density", 1, 2), two_voxels<openvdb::BoolGrid>("flags", true, true)});
  EXPECT_EQ(must_grid(folder / "v.vdb").name, "density");
  EXPECT_EQ(must_grid(folder / "v.vdb", "flags").type(), field::SampleType::u8);
  EXPECT_FALSE(try_grid(folder / "v.vdb", "density[x]"));
}

TEST(OpenVdbVolume, FrustumsAreResampled) {
  NEEDS_OPENVDB_PLUGIN();
  openvdb::initialize();
  // Voxels at the far plane are twice as large as at the near one.
  const auto transform =
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {40, 40, 40}), 0.5, 4, 0.1);
  const auto grid = openvdb::FloatGrid::create();
  grid->setName("v");
  grid->setTransform(transform);
  // The world's z: what is linear in the world is hit by interpolation within a voxel's bend.
  for (const openvdb::Coord& at : openvdb::CoordBBox({0, 0, 0}, {40, 40, 40})) {
    grid->tree().setValue(at, static_cast<float>(transform->indexToWorld(at).z()));
  }
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {grid});
  const field::ScalarField field = must_grid(folder / "v.vdb");
  EXPECT_TRUE(has_note(field, "resampled, trilinearly, to cubic voxels with a spacing of "));
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

TEST(OpenVdbVolume, WithoutThePluginTheMessageNamesIt) {
  const TempFolder folder;
  const auto bent = two_voxels<openvdb::FloatGrid>("bent", 1, 2);
  bent->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {100, 100, 100}), 0.5, 10, 0.1));
  write_vdb(folder / "v.vdb", {bent, two_voxels<openvdb::Vec3SGrid>("velocity", {1, 0, 0}, {0, 1, 0})});
  const auto missing = volumes::make_vdb_format({"/nowhere"});
  for (const std::string grid : {"bent", "velocity[x]"}) {
    volumes::ReadOptions options;
    options.grid = grid;
    const auto field = missing->open((folder / "v.vdb").string(), options, Context());
    ASSERT_FALSE(field);
    EXPECT_EQ(field.error().code, ErrorCode::unavailable);
    expect_in(field.error().message, "isoextract-volume-openvdb.so, which is in none of: /nowhere");
    expect_in(field.error().message, grid == "bent" ? "'bent' lies in a frustum" : "'velocity' holds vec3s");
  }
  const auto listed = missing->list((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->size(), 2U);
}

TEST(OpenVdbVolume, MemoryIsReservedAndGivenBack) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {two_voxels<openvdb::BoolGrid>("flags", true, true)});
  const auto refused = try_grid(folder / "v.vdb", "flags", with_memory(1000));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint.remedy, Remedy::raise_memory_limit);
  const Context context;
  {
    const auto field = try_grid(folder / "v.vdb", "flags", context);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_GE(context.memory().reserved(), 2U * 512U);
    EXPECT_LE(context.memory().reserved(), 2U * 512U + 10000U);
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

// Each component holds its coordinate where OpenVDB's sampler of staggered grids takes it from.
TEST(OpenVdbVolume, ComponentsOfStaggeredGridsAreOnTheFacesOfVoxels) {
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

TEST(OpenVdbVolume, CutFilesAreRefused) {
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

// Points at `places` with attributes of several types.
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

TEST(OpenVdbPoints, PositionsAndAttributes) {
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

TEST(OpenVdbPoints, ThePositionIsAnAttributeToo) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  volumes::ParticleReadOptions options;
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

TEST(OpenVdbPoints, AnAttributeOfFewerPointsIsDamage) {
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
  volumes::ParticleReadOptions options;
  options.attributes = {"heat"};
  const auto read = try_points(folder / "p.vdb", options);
  ASSERT_FALSE(read);
  expect_in(read.error().message, "the file is damaged: expected a value of 'heat' for each point");
  EXPECT_TRUE(try_points(folder / "p.vdb"));
}

// Where the file tells of an array of `bytes_per_point` for each of some points of a leaf: the places of the numbers of
// bytes, which count six more.
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

TEST(OpenVdbPoints, AnArrayOfFewerBytesThanItsPointsNeedIsDamage) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5)});
  std::string file = read_bytes(folder / "p.vdb");
  const auto arrays = places_of_arrays(file, 12);  // positions and velocities
  ASSERT_GE(arrays.size(), 2U);
  // What one array lacks the next one has, so that all of them together are as large as they were.
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

TEST(OpenVdbPoints, DamagedFilesEndNothing) {
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
    EXPECT_EQ(read.error().code, ErrorCode::input) << i << ": " << read.error().message;
  }
  EXPECT_GT(refused, 10);
}

TEST(OpenVdbPoints, FilesOfPointsAloneAreParticles) {
  const TempFolder folder;
  const auto drops = point_grid("drops", some_places(), 0.5);
  write_vdb(folder / "points.vdb", {drops});
  write_vdb_stream(folder / "piped.vdb", {drops});
  write_vdb(folder / "both.vdb", {drops, two_voxels<openvdb::FloatGrid>("density", 1, 2)});
  const auto kind = [&](const std::string& name, const std::string& grid = "") {
    volumes::ParticleReadOptions options;
    if (!grid.empty()) options.grid = grid;
    const auto found = volumes::detect_particles((folder / name).string(), options, Context());
    return found && *found ? (*found)->id : "none";
  };
  EXPECT_EQ(kind("points.vdb"), "openvdb");
  EXPECT_EQ(kind("piped.vdb"), "openvdb");
  EXPECT_EQ(kind("both.vdb"), "none");
  EXPECT_EQ(kind("both.vdb", "drops"), "openvdb");
  EXPECT_EQ(kind("both.vdb", "density"), "none");
  const auto formats = volumes::find_particle_plugins({"/nowhere"});
  const auto missing = try_points(folder / "points.vdb", {}, *formats[1]);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::unavailable);
  expect_in(missing.error().message, "isoextract-particles-openvdb.so");
}

TEST(OpenVdbPoints, OneOfSeveralGridsIsNamed) {
  NEEDS_OPENVDB_PLUGIN();
  const TempFolder folder;
  auto few = some_places();
  few.resize(3);
  write_vdb(folder / "p.vdb", {point_grid("drops", some_places(), 0.5), point_grid("foam", few, 0.5),
                               two_voxels<openvdb::FloatGrid>("density", 1, 2)});
  volumes::ParticleReadOptions options;
  options.grid = "foam";
  const auto foam = try_points(folder / "p.vdb", options);
  ASSERT_TRUE(foam) << foam.error().message;
  EXPECT_EQ(foam->particles.size(), 3U);
  const auto unnamed = try_points(folder / "p.vdb");
  ASSERT_FALSE(unnamed);
  expect_in(unnamed.error().message, "expected the name of one of its grids of points: 'drops', 'foam'");
  options.grid = "density";
  expect_in(try_points(folder / "p.vdb", options).error().message, "there is no grid of points 'density'");
}

TEST(OpenVdbPoints, CutFilesAreRefused) {
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

// Tests the list of a VDB file's grids: names, counts, transforms.
#include <array>

#include "support/hints.hpp"
#include "unit/volume_io/vdb_files.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

openvdb::FloatGrid::Ptr one_voxel(const std::string& name, int x = 0) {
  openvdb::initialize();
  const auto grid = openvdb::FloatGrid::create();
  grid->setName(name);
  grid->tree().setValue({x, 0, 0}, 1);
  return grid;
}

// The file's suffixes distinguish equal names; k in NAME[k] avoids labels that are other grids' names.
TEST(VdbGridList, HasUniqueLabelsThatSelectTheirGrid) {
  const std::vector<std::string> names{"density",
                                       "density",
                                       "density[0]",
                                       "density[2]",
                                       "density",
                                       "fl\u00e4che",
                                       "x\x1b[2J",
                                       R"(x\x1b[2J)",
                                       "tab\tbed",
                                       "\xff",
                                       "a[0]",
                                       "a[0]",
                                       std::string(300, 'l') + "1",
                                       std::string(300, 'l') + "2",
                                       ""};
  const std::string shown = std::string(200, 'l') + "...";
  const std::vector<std::string> labels{"density[1]",  "density[3]",     "density[0]",     "density[2]",  "density[4]",
                                        "fl\u00e4che", R"(x\x1b[2J[0])", R"(x\x1b[2J[1])", R"(tab\tbed)", R"(\xff)",
                                        "a[0][0]",     "a[0][1]",        shown + "[0]",    shown + "[1]", ""};
  openvdb::GridCPtrVec grids;
  for (std::size_t i = 0; i < names.size(); ++i) grids.push_back(one_voxel(names[i], static_cast<int>(i)));
  const TempFolder folder;
  write_vdb(folder / "v.vdb", grids);
  const auto listed = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(listed);
  ASSERT_EQ(listed->size(), names.size());
  const auto x_of = [&](const std::string& wanted) {
    volume_io::ReadOptions options;
    options.grid = wanted;
    return std::get<field::SparseSamples>(must_read(folder / "v.vdb", options).samples).active_box.min.x;
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(listed->at(i).name, names[i]);
    EXPECT_EQ(listed->at(i).label, labels[i]);
    EXPECT_EQ(x_of(labels[i]), static_cast<int>(i)) << labels[i];
  }
  for (const std::size_t i : {5U, 6U, 8U, 9U, 12U}) EXPECT_EQ(x_of(names[i]), static_cast<int>(i)) << "by its bytes";
  for (const std::string& several : {std::string("density"), std::string("a[0]"), std::string(R"(x\x1b[2J)")}) {
    volume_io::ReadOptions options;
    options.grid = several;
    EXPECT_TRUE(test::has_step(refusal(folder / "v.vdb", options).hint, Remedy::choose, Setting::grid)) << several;
  }
}

TEST(VdbGridList, DistinguishesUncountedFromEmpty) {
  openvdb::initialize();
  const auto velocity = openvdb::Vec3SGrid::create();
  velocity->setName("velocity");
  velocity->tree().setValue({1, 2, 3}, openvdb::Vec3s(1, 2, 3));
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {velocity, openvdb::FloatGrid::create(), one_voxel("damaged")},
            openvdb::io::COMPRESS_ACTIVE_MASK, false);
  std::string bytes = read_bytes(folder / "v.vdb");
  // The number of buffers of the last grid's tree, after the five vectors of its transform.
  const std::size_t map = bytes.rfind("UniformScaleMap");
  put(bytes, map + 15 + 15 * sizeof(double), 2);
  write_bytes(folder / "v.vdb", bytes);
  const auto grids = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(grids);
  EXPECT_FALSE(grids->at(0).voxels);
  EXPECT_EQ(grids->at(1).voxels, 0U);
  EXPECT_FALSE(grids->at(2).voxels);
  EXPECT_TRUE(grids->at(0).box.empty());
  const Error error = refusal(folder / "v.vdb");
  expect_in(test::text_of(error.hint), "float  not counted");
  expect_in(test::text_of(error.hint), "float  empty");
}

TEST(VdbGridList, ReportsVectorKinds) {
  openvdb::initialize();
  std::vector<openvdb::GridBase::Ptr> grids;
  for (const auto type : {openvdb::VEC_INVARIANT, openvdb::VEC_COVARIANT, openvdb::VEC_COVARIANT_NORMALIZE,
                          openvdb::VEC_CONTRAVARIANT_RELATIVE, openvdb::VEC_CONTRAVARIANT_ABSOLUTE}) {
    const auto grid = openvdb::Vec3SGrid::create();
    grid->tree().setValue({1, 2, 3}, openvdb::Vec3s(1, 2, 3));
    grid->setVectorType(type);
    grid->setIsInWorldSpace(type != openvdb::VEC_CONTRAVARIANT_RELATIVE);
    grids.push_back(grid);
  }
  grids.push_back(openvdb::Vec3SGrid::create());  // the default, which means nothing
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {grids.begin(), grids.end()});
  const auto listed = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(listed);
  const std::array<std::optional<AttributeKind>, 6> kinds{
      std::nullopt, std::nullopt, AttributeKind::normal, AttributeKind::vector, AttributeKind::point, std::nullopt};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    EXPECT_EQ(listed->at(i).kind_of_vectors, kinds[i]) << i;
    EXPECT_EQ(listed->at(i).vectors_in_voxels, i == 3) << i;
  }
}

TEST(VdbGridList, ListsGridsBesideAnUnusableTransform) {
  openvdb::initialize();
  const auto bent = one_voxel("bent");
  bent->setTransform(
      openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {100, 100, 100}), 0.5, 10, 0.1));
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {one_voxel("first"), bent, one_voxel("strange")});
  std::string bytes = read_bytes(folder / "v.vdb");
  bytes[bytes.rfind("UniformScaleMap")] = 'X';
  write_bytes(folder / "v.vdb", bytes);
  const auto grids = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(grids);
  const std::array<std::string, 3> problems{"", "expected a linear transform, found NonlinearFrustumMap",
                                            "expected a linear transform, found 'XniformScaleMap'"};
  for (std::size_t i = 0; i < problems.size(); ++i) {
    EXPECT_EQ(grids->at(i).placement_problem, problems[i]);
    EXPECT_EQ(grids->at(i).voxels, 1U);
  }
  volume_io::ReadOptions options;
  options.grid = "first";
  EXPECT_EQ(std::get<field::SparseSamples>(must_read(folder / "v.vdb", options).samples).active_voxels, 1U);
  options.grid = "strange";
  expect_in(refusal(folder / "v.vdb", options).message, "is not supported: expected a linear transform, found 'Xni");
}

TEST(VdbGridList, ListsGridsBesideADamagedTransform) {
  openvdb::initialize();
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {one_voxel("first"), one_voxel("second")});
  std::string bytes = read_bytes(folder / "v.vdb");
  bytes.replace(bytes.rfind("UniformScaleMap") - 4, 4, "\xff\xff\xff\xff");  // length of that name
  write_bytes(folder / "v.vdb", bytes);
  const auto grids = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(grids);
  EXPECT_EQ(grids->at(0).placement_problem, "");
  expect_in(grids->at(1).placement_problem, "it is damaged: expected a name of 4294967295 bytes");
  volume_io::ReadOptions options;
  options.grid = "first";
  EXPECT_EQ(std::get<field::SparseSamples>(must_read(folder / "v.vdb", options).samples).active_voxels, 1U);
  options.grid = "second";
  expect_in(refusal(folder / "v.vdb", options).message, "the VDB file is damaged: expected a name of 4294967295 bytes");
}

TEST(VdbGridList, DistinguishesUnsupportedFromDamaged) {
  const TempFolder folder;
  write_vdb(folder / "v.vdb", {one_voxel(std::string(70000, 'n'))});
  expect_in(refusal(folder / "v.vdb").message, "the VDB file is not supported: a name is 70000 characters long");
  write_vdb(folder / "v.vdb", {one_voxel("other")});
  std::string bytes = read_bytes(folder / "v.vdb");
  bytes.replace(bytes.find("Tree_float_5_4_3"), 16, "Tree_float_4_4_3");
  write_bytes(folder / "v.vdb", bytes);
  volume_io::ReadOptions options;
  options.grid = "other";
  expect_in(refusal(folder / "v.vdb", options).message, "but 'other' has values of type float (tree 4_4_3)");
}

TEST(VdbGridList, ReportsTheCreatorOfGridOrFile) {
  openvdb::initialize();
  const auto own = one_voxel("own");
  own->setCreator("Houdini/SOP_\x1b");
  const TempFolder folder;
  openvdb::MetaMap of_file;
  of_file.insertMeta("creator", openvdb::StringMetadata("Blender/Smoke"));
  openvdb::io::File file((folder / "v.vdb").string());
  file.write(openvdb::GridCPtrVec{own, one_voxel("plain")}, of_file);
  file.close();
  const auto listed = volume_io::list_grids((folder / "v.vdb").string(), {}, Context());
  ASSERT_TRUE(listed);
  EXPECT_EQ(listed->at(0).creator, R"(Houdini/SOP_\x1b)");
  EXPECT_EQ(listed->at(1).creator, "Blender/Smoke");
  volume_io::ReadOptions options;
  options.grid = "plain";
  EXPECT_EQ(must_read(folder / "v.vdb", options).creator, "Blender/Smoke");
  write_vdb(folder / "none.vdb", {one_voxel("plain")});
  EXPECT_EQ(must_read(folder / "none.vdb", options).creator, "");
}

}  // namespace
}  // namespace isoextract::test

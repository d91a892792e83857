#include <gtest/gtest.h>

#include "base/version.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/mesh_file_parsers.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

std::string write_obj_text(std::span<const mesh::Mesh> meshes, bool flat = false) {
  const TempFolder folder;
  const auto result = must_write(meshes, folder / "out.obj", {MeshFormat::obj, flat, false});
  EXPECT_TRUE(result.notes.empty());
  return read_bytes(folder / "out.obj");
}

TEST(ObjWriter, WritesShortestNumbersThatReadBack) {
  const std::vector<mesh::Mesh> meshes =
      one(make_mesh("t", {{0.1F, -0.0F, 1e-7F}, {1, 16777216, 0.5F}, {0, 3e38F, -2}}, {{0, 1, 2}}));
  EXPECT_EQ(write_obj_text(meshes),
            "# " + std::string(generator()) + "\no t\nv 0.1 -0 1e-07\nv 1 16777216 0.5\nv 0 3e+38 -2\nf 1 2 3\n");
}

TEST(ObjWriter, KeepsPositionsNormalsAndTriangles) {
  const std::vector<mesh::Mesh> meshes = one(sphere(60, true));
  const auto found = parse_obj(write_obj_text(meshes));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(same_local_positions(meshes[0], found[0]));
  EXPECT_TRUE(same_values(meshes[0].normals, found[0].normals));
  EXPECT_TRUE(same_values(meshes[0].triangles, found[0].triangles));
}

TEST(ObjWriter, WritesOneFlatNormalPerFace) {
  std::vector<mesh::Mesh> meshes = one(sphere(20, false, "first"));
  meshes.push_back(tetrahedron("second"));
  const auto found = parse_obj(write_obj_text(meshes, true));
  ASSERT_EQ(found.size(), 2U);
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    EXPECT_TRUE(same_face_normals(meshes[m], found[m].face_normals));
    EXPECT_TRUE(same_values(meshes[m].triangles, found[m].triangles));
  }
}

// Indices count through the whole file, separately for normals and vertices.
TEST(ObjWriter, KeepsSeveralMeshesApart) {
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(tetrahedron("iso 0.5"));
  meshes.push_back(make_mesh("nothing", {}, {}));
  meshes.push_back(sphere(5, true, "iso 1"));
  meshes.push_back(tetrahedron("after normals"));
  meshes.push_back(sphere(6, true, "iso 2"));
  const auto found = parse_obj(write_obj_text(meshes));
  ASSERT_EQ(found.size(), meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    EXPECT_EQ(found[m].name, meshes[m].name);
    EXPECT_TRUE(same_local_positions(meshes[m], found[m]));
    EXPECT_TRUE(same_values(meshes[m].normals, found[m].normals));
    EXPECT_TRUE(same_values(meshes[m].triangles, found[m].triangles));
  }
}

TEST(ObjWriter, WritesPositionsFarFromOriginAsDoubles) {
  const std::vector<mesh::Mesh> meshes = one(sphere(10, true, "far", {1e7 + 1.0 / 3, -5e8, 1e-9}));
  const auto found = parse_obj(write_obj_text(meshes));
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(same_positions(meshes[0], found[0]));
}

TEST(ObjWriter, KeepsNameOnOneLine) {
  const std::vector<mesh::Mesh> meshes = one(make_mesh("a\nv 1 2 3\r", {}, {}));
  EXPECT_EQ(write_obj_text(meshes), "# " + std::string(generator()) + "\no a v 1 2 3 \n");
}

}  // namespace
}  // namespace isoextract::mesh_io

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

class StlWriter : public testing::TestWithParam<bool> {
 protected:
  ParsedMesh round_trip(const mesh::Mesh& mesh, bool flat = false) {
    result_ = must_write(std::span(&mesh, 1), folder_ / "out.stl", {MeshFormat::stl, flat, GetParam()});
    bytes_ = read_bytes(folder_ / "out.stl");
    return GetParam() ? parse_ascii_stl(bytes_) : parse_binary_stl(bytes_);
  }

  TempFolder folder_;
  MeshWriteResult result_;
  std::string bytes_;
};

INSTANTIATE_TEST_SUITE_P(Both, StlWriter, testing::Bool(),
                         [](const auto& test) { return std::string(test.param ? "ascii" : "binary"); });

TEST_P(StlWriter, KeepsCornersAndWritesFaceNormals) {
  const mesh::Mesh mesh = sphere(60, true);
  const ParsedMesh found = round_trip(mesh);
  ASSERT_EQ(found.triangles.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (unsigned corner = 0; corner < 3; ++corner) {
      ASSERT_EQ(found.positions[3 * t + corner], mesh.position(mesh.triangles[t][static_cast<int>(corner)]));
    }
  }
  EXPECT_TRUE(same_face_normals(mesh, found.face_normals));
  EXPECT_TRUE(result_.notes.empty());
  const bool starts_with_solid = bytes_.starts_with("solid");
  EXPECT_EQ(starts_with_solid, GetParam());
  EXPECT_EQ(bytes_.starts_with(generator()), !GetParam());
}

TEST_P(StlWriter, WritesNormalOfTriangleWithoutArea) {
  const ParsedMesh found = round_trip(make_mesh("line", {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}));
  EXPECT_EQ(found.face_normals, (std::vector<glm::vec3>{{0, 0, 1}}));
}

TEST_P(StlWriter, WritesFiniteNormalsOfExtremeTriangles) {
  const float tiny = 1e-44F;  // subnormal: products of such lengths underflow in float but not in double
  const float huge = 3e38F;
  const mesh::Mesh mesh =
      make_mesh("edges", {{0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}, {-huge, -huge, 0}, {huge, -huge, 0}, {0, huge, 0}},
                {{0, 1, 2}, {3, 4, 5}});
  EXPECT_EQ(round_trip(mesh).face_normals, (std::vector<glm::vec3>{{0, 0, 1}, {0, 0, 1}}));
}

TEST_P(StlWriter, NotesPrecisionLossFarFromOrigin) {
  const mesh::Mesh mesh = sphere(9, false, "far", {16384.0, 0, 0.25});
  const ParsedMesh found = round_trip(mesh);
  EXPECT_EQ(found.positions[0], glm::dvec3(glm::vec3(mesh.position(mesh.triangles[0][0]))));
  ASSERT_EQ(result_.notes.size(), 1U);
  EXPECT_EQ(result_.notes[0].text,
            "STL stores only float32 coordinates: at 16385, the largest, neighboring values are 0.00195 apart; glb, "
            "gltf, ply and obj store the full precision");
  round_trip(sphere(9, false, "near", {16, 0, 0.25}));  // moved by less than a thousandth of an edge
  EXPECT_TRUE(result_.notes.empty());
}

TEST_P(StlWriter, WritesEmptySurface) { EXPECT_TRUE(round_trip(make_mesh("nothing", {}, {})).triangles.empty()); }

TEST(StlWriterNames, KeepsNameOnOneLine) {
  const TempFolder folder;
  const std::vector<mesh::Mesh> meshes = one(make_mesh("a\nb", {}, {}));
  must_write(meshes, folder / "out.stl", {MeshFormat::stl, false, true});
  EXPECT_EQ(read_bytes(folder / "out.stl"), "solid a b\nendsolid a b\n");
}

}  // namespace
}  // namespace isoextract::mesh_io

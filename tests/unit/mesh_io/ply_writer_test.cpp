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

class PlyWriter : public testing::TestWithParam<bool> {
 protected:
  ParsedPly round_trip(const mesh::Mesh& mesh, bool flat = false) {
    const auto result = must_write(std::span(&mesh, 1), folder_ / "out.ply", {MeshFormat::ply, flat, GetParam()});
    EXPECT_TRUE(result.notes.empty());
    const std::string bytes = read_bytes(folder_ / "out.ply");
    EXPECT_EQ(result.files.at(0).bytes, bytes.size());
    return parse_ply(bytes);
  }

  TempFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Both, PlyWriter, testing::Bool(),
                         [](const auto& test) { return std::string(test.param ? "ascii" : "binary"); });

TEST_P(PlyWriter, KeepsPositionsAndTriangles) {
  const mesh::Mesh mesh = tetrahedron();
  const ParsedPly ply = round_trip(mesh);
  EXPECT_TRUE(same_local_positions(mesh, ply.mesh));
  EXPECT_TRUE(same_values(mesh.triangles, ply.mesh.triangles));
  EXPECT_TRUE(ply.mesh.normals.empty() && ply.mesh.face_normals.empty());
  EXPECT_EQ(ply.position_type, "float");
  EXPECT_NE(ply.header.find("comment " + std::string(generator()) + "\n"), std::string::npos);
}

TEST_P(PlyWriter, KeepsVertexNormals) {
  const mesh::Mesh mesh = sphere(60, true);
  const ParsedPly ply = round_trip(mesh);
  EXPECT_TRUE(same_local_positions(mesh, ply.mesh));
  EXPECT_TRUE(same_values(mesh.normals, ply.mesh.normals));
  EXPECT_TRUE(same_values(mesh.triangles, ply.mesh.triangles));
}

TEST_P(PlyWriter, WritesFlatNormalsOnFaces) {
  const mesh::Mesh mesh = sphere(60, false);
  const ParsedPly ply = round_trip(mesh, true);
  EXPECT_TRUE(same_local_positions(mesh, ply.mesh));
  EXPECT_TRUE(same_values(mesh.triangles, ply.mesh.triangles));
  EXPECT_TRUE(ply.mesh.normals.empty());
  EXPECT_TRUE(same_face_normals(mesh, ply.mesh.face_normals));
}

TEST_P(PlyWriter, WritesPositionsFarFromOriginAsDoubles) {
  for (const bool normals : {false, true}) {
    const mesh::Mesh mesh = sphere(10, normals, "far", {1e7 + 1.0 / 3, -5e8, 1e-9});
    const ParsedPly ply = round_trip(mesh);
    EXPECT_EQ(ply.position_type, "double");
    EXPECT_TRUE(same_positions(mesh, ply.mesh));
    EXPECT_TRUE(same_values(mesh.normals, ply.mesh.normals));
  }
}

TEST_P(PlyWriter, WritesEmptySurface) {
  const ParsedPly ply = round_trip(make_mesh("nothing", {}, {}));
  EXPECT_TRUE(ply.mesh.positions.empty() && ply.mesh.triangles.empty());
}

}  // namespace
}  // namespace isoextract::mesh_io

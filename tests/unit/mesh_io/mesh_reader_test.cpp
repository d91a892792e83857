#include "mesh_io/mesh_reader.hpp"

#include <cmath>
#include <cstring>
#include <filesystem>
#include <tuple>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/mesh_reader_fixture.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using test::bytes_of;
using test::gltf;
using test::MeshReaderTest;
using test::word;
using test::write_bytes;

struct Written {
  std::string_view name;
  MeshWriteOptions options;
};

class RoundTripTest : public MeshReaderTest, public testing::WithParamInterface<Written> {};

TEST_P(RoundTripTest, KeepsPositionsAndTriangles) {
  for (const bool normals : {false, true}) {
    const auto meshes = test::one(test::sphere(9, normals && !GetParam().options.flat_normals));
    test::must_write(meshes, folder_ / std::string(GetParam().name), GetParam().options);
    const MeshFile read = must_read(std::string(GetParam().name));
    const mesh::Mesh& mesh = read.mesh;
    EXPECT_EQ(mesh.name, GetParam().name);
    EXPECT_TRUE(read.notes.empty());
    EXPECT_EQ(mesh.origin, glm::dvec3(0));
    const bool soup = GetParam().options.format == MeshFormat::stl || GetParam().options.flat_normals;
    if (soup && GetParam().options.format != MeshFormat::ply && GetParam().options.format != MeshFormat::obj) {
      // Vertices are in the order in which triangles refer to them.
      ASSERT_EQ(mesh.positions.size(), meshes[0].positions.size());
      ASSERT_EQ(mesh.triangles.size(), meshes[0].triangles.size());
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        for (int corner = 0; corner < 3; ++corner) {
          EXPECT_EQ(mesh.positions[mesh.triangles[t][corner]], meshes[0].positions[meshes[0].triangles[t][corner]]);
        }
      }
      EXPECT_TRUE(mesh::measure_topology(mesh).is_closed_oriented_manifold());
    } else {
      EXPECT_TRUE(test::same_values(meshes[0].positions, {mesh.positions.begin(), mesh.positions.end()}));
      EXPECT_TRUE(test::same_values(meshes[0].triangles, {mesh.triangles.begin(), mesh.triangles.end()}));
    }
  }
}

TEST_P(RoundTripTest, KeepsPositionsFarFromOrigin) {
  const bool stl = GetParam().options.format == MeshFormat::stl;  // float32 in the file
  const glm::dvec3 origin = stl ? glm::dvec3(1e4, -1e4 + 0.125, 3e4) : glm::dvec3(1e7, -1e7 + 0.125, 3e7);
  const auto meshes = test::one(test::sphere(9, false, "far", origin));
  test::must_write(meshes, folder_ / std::string(GetParam().name), GetParam().options);
  const mesh::Mesh mesh = must_read(std::string(GetParam().name)).mesh;
  EXPECT_NEAR(glm::length(mesh.origin - origin), 0, 1);
  ASSERT_EQ(mesh.triangles.size(), meshes[0].triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec3 wanted = meshes[0].position(meshes[0].triangles[t][corner]);
      const glm::dvec3 found = mesh.position(mesh.triangles[t][corner]);
      EXPECT_NEAR(glm::length(found - wanted), 0, stl ? 3e-3 : 2e-7);
    }
  }
  const bool gltf = GetParam().options.format == MeshFormat::glb || GetParam().options.format == MeshFormat::gltf;
  if (gltf) {
    EXPECT_EQ(mesh.origin, origin);
    if (!GetParam().options.flat_normals) {
      EXPECT_TRUE(test::same_values(meshes[0].positions, {mesh.positions.begin(), mesh.positions.end()}));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Formats, RoundTripTest,
                         testing::Values(Written{"a.glb", {MeshFormat::glb, false, false}},
                                         Written{"flat.glb", {MeshFormat::glb, true, false}},
                                         Written{"a b%.gltf", {MeshFormat::gltf, false, false}},
                                         Written{"a.ply", {MeshFormat::ply, false, false}},
                                         Written{"flat.ply", {MeshFormat::ply, true, false}},
                                         Written{"text.ply", {MeshFormat::ply, false, true}},
                                         Written{"flattext.ply", {MeshFormat::ply, true, true}},
                                         Written{"a.obj", {MeshFormat::obj, false, false}},
                                         Written{"flat.obj", {MeshFormat::obj, true, false}},
                                         Written{"a.stl", {MeshFormat::stl, true, false}},
                                         Written{"text.stl", {MeshFormat::stl, true, true}}));

TEST_F(MeshReaderTest, JoinsSeveralSurfaces) {
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(test::tetrahedron("a"));
  meshes.push_back(test::sphere(5, true, "b", {1e7, 0, 0}));
  for (const auto& [name, format] : {std::pair("two.glb", MeshFormat::glb), std::pair("two.obj", MeshFormat::obj)}) {
    test::must_write(meshes, folder_ / name, {format, false, false});
    const mesh::Mesh mesh = must_read(name).mesh;
    EXPECT_EQ(mesh.triangles.size(), meshes[0].triangles.size() + meshes[1].triangles.size());
    EXPECT_EQ(mesh::measure_topology(mesh).components, 2U);
    EXPECT_NEAR(mesh::measure_bounds(mesh).max.x, 1e7 + 1, 0.5);
  }
}

TEST_F(MeshReaderTest, ReadsEmptyMeshes) {
  const auto nothing = test::one(mesh::Mesh{});
  test::must_write(nothing, folder_ / "none.glb", {MeshFormat::glb, false, false});
  EXPECT_TRUE(must_read("none.glb").mesh.triangles.empty());
  for (const auto& [name, format] : {std::pair("none.ply", MeshFormat::ply), std::pair("none.obj", MeshFormat::obj),
                                     std::pair("none.stl", MeshFormat::stl)}) {
    test::must_write(nothing, folder_ / name, {format, format == MeshFormat::stl, false});
    EXPECT_TRUE(must_read(name).mesh.triangles.empty());
  }
}

TEST_F(MeshReaderTest, ReadsObjPolygonsAndRelativeIndices) {
  const MeshFile read = read_text("a.obj",
                                  "# a pyramid\nmtllib none.mtl\nv 0 0 0 1.0\r\nv 1 0 0\nv 1 1 0\nv +0 1e0 0\n"
                                  "v .5 .5 1\nvt 0 0\nf 4/1 3/1 2/1 1/1\nf -5 -4 -1\nf 2//7 3//7 5//7\nf 3 4 5\n"
                                  "f 4 1 5\nl 1 2\ns off");
  EXPECT_EQ(read.mesh.triangles.size(), 6U);
  EXPECT_TRUE(mesh::measure_topology(read.mesh).is_closed_oriented_manifold());
  EXPECT_NEAR(mesh::measure_size(read.mesh).volume, 1.0 / 3, 1e-7);
  ASSERT_EQ(read.notes.size(), 1U);
  EXPECT_NE(read.notes[0].text.find("1 lines and points"), std::string::npos);
}

TEST_F(MeshReaderTest, ReadsPlyOfOtherPrograms) {
  const std::string header =
      "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement material 2\r\nproperty list uchar int ids\r\nproperty float "
      "a\r\n"
      "element vertex 4\r\nproperty uchar red\r\nproperty double z\r\nproperty int16 y\r\nproperty float64 x\r\n"
      "element face 1\r\nproperty list uint8 int32 vertex_index\r\nend_header\r\n";
  const MeshFile read = read_text("a.ply", header +
                                               "0 1.5\r\n2 7 8 2\r\n9 0 0 10000000.125\n9 0 0 10000000.25\n9 0.5 1 "
                                               "10000001.5\n9 0 1 10000000.25\n4 0 1 2 3");
  ASSERT_EQ(read.mesh.triangles.size(), 2U);
  EXPECT_EQ(read.mesh.triangles[1], glm::uvec3(0, 2, 3));
  EXPECT_EQ(read.mesh.position(2).z, 0.5);
  EXPECT_NEAR(read.mesh.position(0).x, 10000000.125, 1e-7);
  EXPECT_NEAR(read.mesh.position(2).x, 10000001.5, 1e-7);
  EXPECT_EQ(read.notes.size(), 1U);

  std::string big =
      "ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar ushort vertex_indices\nend_header\n";
  std::string body = bytes_of({1, 2, 3, 4, 5, 6, 7, 8, 10});
  for (std::size_t i = 0; i < body.size(); i += 4)
    std::reverse(body.begin() + static_cast<long>(i), body.begin() + static_cast<long>(i) + 4);
  body += std::string("\3\0\2\0\1\0\0", 7);
  const MeshFile swapped = read_text("big.ply", big + body);
  EXPECT_EQ(swapped.mesh.position(2), glm::dvec3(7, 8, 10));
  EXPECT_EQ(swapped.mesh.triangles[0], glm::uvec3(2, 1, 0));
}

TEST_F(MeshReaderTest, HandlesNumbersOutsideRangeOfDouble) {
  const std::string zeros(400, '0');
  const auto with = [](const std::string& x) { return fmt::format("v {} 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", x); };
  const std::vector<std::string> small{"1E-400", "-1e-400", "0." + zeros + "1", "0." + zeros + "1e5", "1e-99999999999"};
  for (const std::string& x : small) EXPECT_EQ(read_text("a.obj", with(x)).mesh.position(0).x, 0) << x;
  for (const char* x : {"1e400", "-1E+400", "1e99999999999"}) expect_error("a.obj", with(x), "finite");
  for (const std::string& x : {"1" + zeros, "1" + zeros + "e-5"}) expect_error("a.obj", with(x), "finite");
  EXPECT_EQ(read_text("a.obj", with("1" + zeros + "e-400")).mesh.position(0).x, 1);
  expect_error("a.obj", with("1e400x"), "line 1: expected a number, found '1e400x'");
}

TEST_F(MeshReaderTest, AppliesGltfNodesInDouble) {
  // A quarter turn around z, then a stretch and a mirror above it, far away.
  const MeshFile read = read_text(
      "a.gltf", gltf(R"({"matrix":[2,0,0,0,0,-3,0,0,0,0,1,0,1e7,0.125,-1e7,1],"children":[1]},)"
                     R"({"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476],"translation":[1,2,3]})"));
  ASSERT_EQ(read.mesh.triangles.size(), 1U);
  const glm::uvec3 t = read.mesh.triangles[0];
  // (0,0,0) -> (1,2,3); (1,0,0) -> (1,3,3); (0,1,0) -> (0,2,3); then x * 2 + 1e7, y * -3 + 0.125, z - 1e7.
  EXPECT_NEAR(glm::length(read.mesh.position(t.x) - glm::dvec3(1e7 + 2, -5.875, 3 - 1e7)), 0, 1e-6);
  const glm::dvec3 normal =
      glm::cross(read.mesh.position(t.y) - read.mesh.position(t.x), read.mesh.position(t.z) - read.mesh.position(t.x));
  EXPECT_NEAR(normal.z, 6, 1e-5) << "a mirror must not turn the surface inside out";
}

TEST_F(MeshReaderTest, RefusesDamagedGltf) {
  const std::string good = gltf(R"({"mesh":0})");
  const auto replaced = [&](const std::string& what, const std::string& with) {
    std::string text = good;
    text.replace(text.find(what), what.size(), with);
    return text;
  };
  read_text("good.gltf", good);
  expect_error("a.gltf", good.substr(0, good.size() - 5), "expected a JSON object");
  expect_error("a.gltf", replaced("\"2.0\"", "\"1.0\""), "expected glTF of version 2, found '1.0'");
  expect_error("a.gltf", replaced("\"count\":3", "\"count\":4"),
               "expected a buffer view with room for 4 values, found 36 bytes");
  expect_error("a.gltf", replaced("\"count\":3", "\"count\":18446744073709551615"), "expected a buffer view with room");
  expect_error("a.gltf", replaced("\"count\":3", "\"count\":-3"),
               "expected a whole number as the value of 'count', found -3");
  expect_error("a.gltf", replaced("\"byteLength\":36}]", "\"byteOffset\":18446744073709551615,\"byteLength\":36}]"),
               "within a buffer");
  expect_error("a.gltf", replaced("\"byteLength\":36,\"uri\"", "\"byteLength\":37,\"uri\""),
               "expected 37 bytes of buffer 0, found 36");
  expect_error("a.gltf", replaced("\"POSITION\":0", "\"POSITION\":1"), "entries of 'accessors', found 1");
  expect_error("a.gltf", replaced("5126", "5123"), "expected positions of component type 5126");
  expect_error("a.gltf", replaced("\"bufferView\":0,\"componentType\"", "\"componentType\""),
               "expected an accessor with values in a buffer");
  expect_error("a.gltf", replaced("\"type\":\"VEC3\"", "\"type\":\"VEC3\",\"sparse\":{}"), "expected 'count' in {}");
  expect_error("a.gltf", replaced("\"type\":\"VEC3\"", "\"type\":\"VEC3\",\"sparse\":[]"), "'sparse' of an accessor");
  expect_error("a.gltf", replaced("\"asset\"", "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"],\"asset\""),
               "EXT_mesh_gpu_instancing");
  expect_error("a.gltf", replaced("data:;base64,", "data:;base64,!"), "base64");
  expect_error("a.gltf", replaced("data:;base64,", "data:;base64;"), "expected a comma");
  expect_error("a.gltf", replaced("data:;base64,AAAAAAAAAAAAAAAA", "data:,"),
               "expected 36 bytes of buffer 0, found 32");
  expect_error("a.gltf", replaced("\"attributes\"", "\"mode\":7,\"attributes\""), "found 7");
  expect_error("a.gltf", gltf(R"({"mesh":0,"children":[0]})"), "found node 0 twice");
  for (const char* children : {"1", "[-1]", R"(["a"])"}) {
    expect_error("a.gltf", gltf(std::string(R"({"mesh":0,"children":)") + children + "}"),
                 "'children': expected a list of node indices, found ");
  }
  expect_error("a.gltf", gltf(R"({"mesh":7})"), "entries of 'meshes', found 7");
  expect_error("a.gltf", gltf(R"({"mesh":0,"matrix":[1,2]})"), "expected 16 numbers as 'matrix'");
  expect_error("a.gltf", gltf(R"({"mesh":0,"scale":[1,null,1]})"), "expected numbers as 'scale'");
  expect_error("a.gltf", gltf(R"({"mesh":0,"scale":[1e308,1e308,1e308],"translation":[1e308,1e308,0]})"), "expected");
  expect_error("a.gltf", gltf(R"({"translation":[1.7e308,0,0],"children":[1]},{"mesh":0,"translation":[1.7e308,0,0]})"),
               "expected a finite position of node 1 in the scene, found (inf, 0, 0)");
  expect_error("a.gltf", gltf(R"({"scale":[1e200,1,1],"children":[1]},{"mesh":0,"scale":[1e200,1,1]})"), "node 1");
  // Recursion into nesting this deep would overflow the stack.
  const std::string deep = std::string(300000, '[') + std::string(300000, ']');
  expect_error("a.gltf", replaced("\"asset\"", "\"extensionsRequired\":" + deep + ",\"asset\""),
               "expected JSON nested at most 64 deep, found a value at depth 65");
  expect_error("a.gltf", deep, "nested at most 64 deep");

  const auto meshes = test::one(test::sphere(4, false));
  test::must_write(meshes, folder_ / "b.gltf", {MeshFormat::gltf, false, false});
  std::filesystem::remove(folder_ / "b.bin");
  expect_error("b.gltf", test::read_bytes(folder_ / "b.gltf"), "names the data file 'b.bin'");
  expect_error("a.gltf", R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":1,"uri":"..%2Fsecret"}]})",
               "outside the folder of the header");
}

TEST_F(MeshReaderTest, ReadsGltfStripsFansAndPercentEncodedData) {
  // A square as a strip and as a fan, with percent-encoded data. The indexed forms store the first corner last.
  const auto square = [&](int mode, const std::vector<glm::vec3>& corners, const std::string& rest) {
    std::string data;
    for (const glm::vec3& p : corners) {
      for (const char byte : bytes_of({p.x, p.y, p.z}))
        data += fmt::format("%{:02X}", static_cast<unsigned char>(byte));
    }
    data += "%03%00%01%02";
    return fmt::format(
        R"({{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[)"
        R"({{"mode":{},"attributes":{{"POSITION":0}}{}}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,)"
        R"("count":4,"type":"VEC3"}},{{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}}],"bufferViews":[)"
        R"({{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":4}}],)"
        R"("buffers":[{{"byteLength":52,"uri":"data:text/plain,{}"}}]}})",
        mode, rest, data);
  };
  const std::string indexed = R"(,"indices":1)";
  const glm::vec3 a(0, 0, 0);
  const glm::vec3 b(1, 0, 0);
  const glm::vec3 c(1, 1, 0);
  const glm::vec3 d(0, 1, 0);
  for (const auto& [name, text] : {
           std::pair("strip", square(5, {a, b, d, c}, "")),
           std::pair("indexed strip", square(5, {b, d, c, a}, indexed)),
           std::pair("fan", square(6, {a, b, c, d}, "")),
           std::pair("indexed fan", square(6, {b, c, d, a}, indexed)),
       }) {
    SCOPED_TRACE(name);
    const MeshFile read = read_text("a.gltf", text);
    EXPECT_TRUE(read.notes.empty());
    ASSERT_EQ(read.mesh.triangles.size(), 2U);
    EXPECT_EQ(read.mesh.positions.size(), 4U);
    EXPECT_EQ(mesh::measure_size(read.mesh).area, 1);
    const mesh::Topology topology = mesh::measure_topology(read.mesh);
    EXPECT_EQ(topology.open_edges, 4U);
    EXPECT_EQ(topology.misoriented_edges, 0U);
    for (const glm::uvec3& t : read.mesh.triangles) {
      const glm::dvec3 p = read.mesh.position(t.x);
      EXPECT_GT(glm::cross(read.mesh.position(t.y) - p, read.mesh.position(t.z) - p).z, 0);
    }
  }
  const MeshFile lines = read_text("a.gltf", square(3, {a, b, c, d}, ""));
  EXPECT_TRUE(lines.mesh.triangles.empty());
  ASSERT_EQ(lines.notes.size(), 1U);
  EXPECT_NE(lines.notes[0].text.find("the reader skips 1 primitives of points or lines"), std::string::npos);
  std::string two = square(5, {a, b, c, d}, "");
  two.replace(two.find("\"count\":4"), 9, "\"count\":2");
  expect_error("a.gltf", two, "expected at least three vertices in a strip or fan, found 2");
}

TEST_F(MeshReaderTest, RefusesDamagedGlb) {
  const auto meshes = test::one(test::sphere(4, false));
  test::must_write(meshes, folder_ / "good.glb", {MeshFormat::glb, false, false});
  const std::string good = test::read_bytes(folder_ / "good.glb");
  for (const std::size_t size : {5U, 12U, 19U, 100U, 1000U}) expect_error("a.glb", good.substr(0, size), "expected");
  expect_error("a.glb", good.substr(0, good.size() - 4), fmt::format("expected {} bytes", good.size()));
  std::string long_chunk = good;
  long_chunk.replace(12, 4, word(0xFFFFFFFF));
  expect_error("a.glb", long_chunk, "expected a chunk of 8 + 4294967295 bytes at byte 12");
  std::string bad_index = good;
  bad_index.replace(bad_index.size() - 4, 2, "\xFF\xFE");
  expect_error("a.glb", bad_index, "expected indices below");
  std::string bad_version = good;
  bad_version[4] = 1;
  expect_error("a.glb", bad_version, "version 2, found 1");
}

TEST_F(MeshReaderTest, RefusesDamagedPly) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string points = "0 0 0\n1 0 0\n0 1 0\n";
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "expected 'end_header'");
  expect_error("a.ply", head + faces + points + "3 0 1 3\n",
               "expected indices below 3, the number of vertices, found 3");
  expect_error("a.ply", head + faces + points + "3 0 1 -1\n", "expected the index of a vertex in face 0, found -1");
  expect_error("a.ply", head + faces + points + "3 0 1 1.5\n", "found 1.5");
  expect_error("a.ply", head + faces + points + "2 0 1 2 3\n", "expected at least 3 corners of face 0, found 2");
  expect_error("a.ply", head + faces + points + "3 0 1\n", "found the end of the file");
  expect_error("a.ply", head + faces + points + "-1 0 1\n", "the length of a list 'vertex_indices', found -1");
  expect_error("a.ply", head + faces + "0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", "expected finite coordinates");
  expect_error("a.ply", head + faces + "0 0 1e999\n1 0 0\n0 1 0\n3 0 1 2\n", "expected finite coordinates");
  expect_error("a.ply", head + faces + "0 0 zero\n1 0 0\n0 1 0\n3 0 1 2\n", "expected a number, found 'zero'");
  expect_error("a.ply", head + faces + "0 0 1e300\n1 0 0\n0 1 -1e300\n3 0 1 2\n", "float32");
  expect_error("a.ply",
               "ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nproperty float y\nproperty "
               "float z\nend_header\n1 2 3\n",
               "expected 99999999999999 elements 'vertex'");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement nothing 99999999999999\nend_header\n", "expected properties");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n1\n", "'half'");
  expect_error("a.ply", "ply\nelement vertex 1\nproperty float x\nend_header\n1\n", "expected a line 'format");
  expect_error("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
               "expected a numeric vertex property 'y'");

  const std::string triangle = points + "3 0 1 2\n";
  const MeshFile more =
      read_text("more.ply", head + "comment made with end_header marker\n" + faces + triangle + "7 8");
  EXPECT_EQ(more.mesh.triangles.size(), 1U);
  ASSERT_EQ(more.notes.size(), 1U);
  EXPECT_NE(more.notes[0].text.find("the reader skips the data after the last element"), std::string::npos);
  EXPECT_TRUE(read_text("blanks.ply", head + faces + triangle + "\n \r\n").notes.empty());
  expect_error("a.ply", head + "end_header now\n" + points, "expected nothing after end_header, found 'now'");

  const auto meshes = test::one(test::sphere(4, false));
  test::must_write(meshes, folder_ / "good.ply", {MeshFormat::ply, false, false});
  const std::string good = test::read_bytes(folder_ / "good.ply");
  expect_error("a.ply", good.substr(0, good.size() - 1), "expected");
  expect_error("a.ply", good.substr(0, good.size() / 2), "expected");
}

TEST_F(MeshReaderTest, RefusesDamagedObj) {
  expect_error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "expected indices below 3");
  expect_error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n",
               "line 4: expected a vertex index from 1 on, or a negative one down to -3");
  expect_error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", "line 4: expected a vertex index from 1 on");
  expect_error("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\n", "at least 3 corners");
  expect_error("a.obj", "v 0 0\n", "line 1: expected a number, found nothing");
  expect_error("a.obj", "v 0 0 0\nf 1 1 99999999999999999999\n", "expected a whole number");
  expect_error("a.obj", "v 0 nan 0\nf 1 1 1\n", "finite");
  expect_error("a.obj", "f 1 2 3\n", "expected vertices");
  expect_error("a.obj",
               std::string("\x7f"
                           "ELF\0\0\1",
                           7),
               "expected text");
}

TEST_F(MeshReaderTest, RefusesDamagedStl) {
  const auto meshes = test::one(test::sphere(4, false));
  test::must_write(meshes, folder_ / "good.stl", {MeshFormat::stl, true, false});
  const std::string good = test::read_bytes(folder_ / "good.stl");
  expect_error("a.stl", good.substr(0, good.size() - 1), fmt::format("found {}", good.size() - 1));
  expect_error("a.stl", good.substr(0, 40), "84 bytes");
  std::string huge = good;
  huge.replace(80, 4, word(0xFFFFFFFF));
  expect_error("a.stl", huge, "for the 4294967295 triangles");
  std::string bad = good;
  bad.replace(84 + 12, 4, word(0x7FC00000));
  expect_error("a.stl", bad, "finite");
  expect_error("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", "3 corners");
  expect_error("a.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "'endsolid'");
  const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n";
  const std::string end = "endloop\nendfacet\n";
  EXPECT_EQ(read_text("two.stl", "solid x\n" + facet + end + "endsolid x\nsolid y\n" + facet + end + "endsolid y\n")
                .mesh.triangles.size(),
            2U);
  expect_error("a.stl", "solid x\n" + facet + end + "facet\nouter loop\nvertex 5 5 5\nvertex 6 5 5\nendsolid x\n",
               "line 13: expected 3 corners before 'endsolid', found '2'");
  expect_error("a.stl", "solid x\n" + facet + "vertex 1 1 0\nvertex 1 2 0\nvertex 1 3 0\n" + end + "endsolid\n",
               "expected 3 corners before 'endloop', found '6'");
  expect_error("a.stl", "solid x\n" + facet + end + "endsolid x\nsolid y\n" + facet, "'endsolid'");
}

TEST_F(MeshReaderTest, RefusesOtherFilesAndLowMemory) {
  expect_error("a.png", "\x89PNG",
               "expected a mesh (.glb, .gltf, .ply, .obj, .stl or .drc), found a file that starts with '\\x89PNG'");
  EXPECT_FALSE(read_mesh(folder_ / "missing.ply", Context()));
  const auto meshes = test::one(test::sphere(9, false));
  for (const MeshFormatInfo& info : mesh_formats()) {
    const auto path = folder_ / fmt::format("small.{}", info.name);
    test::must_write(meshes, path, {info.format, info.format == MeshFormat::stl, false});
    const auto read = read_mesh(path, Context(MemoryBudget(100)));
    ASSERT_FALSE(read) << info.name;
    EXPECT_NE(read.error().message.find("the limit is 100 B"), std::string::npos) << read.error().message;
    EXPECT_EQ(read.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  }
}

// Small files whose meshes need far more memory than their bytes.
TEST_F(MeshReaderTest, KeepsMemoryLimit) {
  const auto expect_beyond = [&](const std::string& name, const std::string& bytes, std::uint64_t limit) {
    write_bytes(folder_ / name, bytes);
    ASSERT_LT(bytes.size(), limit);
    EXPECT_TRUE(read_mesh(folder_ / name, Context())) << name;
    const auto read = read_mesh(folder_ / name, Context(MemoryBudget(limit)));
    ASSERT_FALSE(read) << name;
    EXPECT_NE(read.error().message.find("its bytes, vertices and triangles would take"), std::string::npos)
        << read.error().message;
    EXPECT_EQ(read.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  };
  constexpr std::uint64_t kMega = 1 << 20;

  write_bytes(folder_ / "big.bin", std::string(kMega, '\0'));
  std::string many = gltf(R"({"mesh":0})");
  const std::size_t end_of_buffers = many.rfind(']');
  for (int i = 0; i < 8; ++i) many.insert(end_of_buffers, R"(,{"byteLength":36,"uri":"big.bin"})");
  expect_beyond("many.gltf", many, 5 * kMega);

  std::string values = gltf(R"({"mesh":0})");
  std::string list = "0";
  for (int i = 0; i < 100000; ++i) list += ",0";
  values.insert(1, R"("extras":[)" + list + "],");
  expect_beyond("values.gltf", values, 4 * kMega);

  std::string polygon = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
  for (int i = 0; i < 100000; ++i) polygon += " 1";
  expect_beyond("polygon.obj", polygon + "\n", kMega);

  std::string vertices;
  for (int i = 0; i < 50000; ++i) vertices += "v 0 0 0\n";
  expect_beyond("vertices.obj", vertices, kMega);

  const std::string fan =
      "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uint uchar vertex_indices\nend_header\n" +
      std::string(12, '\0') + word(200000) + std::string(200000, '\0');
  expect_beyond("fan.ply", fan, 3 * kMega);

  std::string soup = "solid x\n";
  for (int i = 0; i < 5000; ++i) soup += "vertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\n";
  expect_beyond("soup.stl", soup + "endsolid\n", 500000);
}

}  // namespace
}  // namespace isoextract::mesh_io

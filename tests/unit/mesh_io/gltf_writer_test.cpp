#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/version.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/hints.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/glb_chunks.hpp"
#include "unit/mesh_io/mesh_file_parsers.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using nlohmann::json;
using namespace test;

// Checks that positions are the stored numbers, bit for bit, and that the origin is separate.
void expect_same_mesh(const mesh::Mesh& expected, const ParsedMesh& found) {
  EXPECT_EQ(found.name, expected.name);
  EXPECT_EQ(found.origin, expected.origin);
  EXPECT_TRUE(same_local_positions(expected, found));
  EXPECT_TRUE(same_values(expected.normals, found.normals));
  EXPECT_TRUE(same_values(expected.triangles, found.triangles));
}

class GltfWriter : public testing::TestWithParam<MeshFormat> {
 protected:
  std::vector<ParsedMesh> round_trip(std::span<const mesh::Mesh> meshes, bool flat = false) {
    const fs::path path = folder_ / ("out." + std::string(mesh_format_info(GetParam()).name));
    result_ = must_write(meshes, path, {GetParam(), flat, false});
    bytes_ = read_bytes(path);
    model_ = GetParam() == MeshFormat::glb ? take_apart(bytes_).model : json::parse(bytes_);
    return load_gltf(path.string());
  }

  TempFolder folder_;
  MeshWriteResult result_;
  std::string bytes_;
  json model_;
};

INSTANTIATE_TEST_SUITE_P(Both, GltfWriter, testing::Values(MeshFormat::glb, MeshFormat::gltf),
                         [](const auto& test) { return std::string(mesh_format_info(test.param).name); });

TEST_P(GltfWriter, KeepsPositionsAndTriangles) {
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  expect_same_mesh(meshes[0], found[0]);
  EXPECT_EQ(model_["asset"]["generator"], generator());
  EXPECT_EQ(model_["asset"]["version"], "2.0");
  EXPECT_EQ(model_["scene"], 0);
  EXPECT_FALSE(model_["nodes"][0].contains("translation"));
  EXPECT_EQ(model_["materials"][0]["pbrMetallicRoughness"]["metallicFactor"], 0.0);
  EXPECT_FALSE(model_["materials"][0].value("doubleSided", false));
  EXPECT_TRUE(result_.notes.empty());
}

// The JSON of many meshes is joined from the text of some at a time.
TEST_P(GltfWriter, JoinsTheJsonOfManyMeshes) {
  std::vector<mesh::Mesh> meshes;
  for (int i = 0; i < 300; ++i) {
    mesh::Mesh mesh = i % 7 == 3 ? mesh::Mesh() : tetrahedron();
    mesh.name = i % 11 == 5 ? std::string() : "mesh " + std::to_string(i / 2);
    mesh.origin = glm::dvec3(i % 5, 0, 0);
    meshes.push_back(std::move(mesh));
  }
  const auto found = round_trip(meshes);
  ASSERT_EQ(model_["nodes"].size(), meshes.size());
  ASSERT_EQ(model_["scenes"][0]["nodes"].size(), meshes.size());
  ASSERT_EQ(found.size(), meshes.size());
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    EXPECT_EQ(model_["scenes"][0]["nodes"][i], i);
    expect_same_mesh(meshes[i], found[i]);
  }
  const bool is_glb = GetParam() == MeshFormat::glb;
  const std::string text = is_glb ? bytes_.substr(20, model_.dump().size()) : bytes_;
  EXPECT_EQ(text, is_glb ? model_.dump() : model_.dump(2) + "\n");  // members in alphabetical order, as in small files
}

TEST_P(GltfWriter, KeepsVertexNormals) {
  const std::vector<mesh::Mesh> meshes = one(sphere(9, true));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  expect_same_mesh(meshes[0], found[0]);
}

// 65535 is the largest number of vertices whose 16-bit indices avoid the restart value.
TEST_P(GltfWriter, UsesShortIndicesBelowRestartValue) {
  for (const std::size_t count : {65535U, 65536U}) {
    mesh::Mesh mesh = sphere(181, false);  // 65,524 vertices
    std::vector<glm::vec3> positions(mesh.positions.begin(), mesh.positions.end());
    std::vector<glm::uvec3> triangles(mesh.triangles.begin(), mesh.triangles.end());
    while (positions.size() < count) positions.emplace_back(positions.size(), 1, 2);
    const auto last = static_cast<unsigned>(count - 1);
    triangles.emplace_back(last, last - 1, last - 2);
    const std::vector<mesh::Mesh> meshes = one(make_mesh("many", positions, triangles));
    const auto found = round_trip(meshes);
    ASSERT_EQ(found.size(), 1U);
    expect_same_mesh(meshes[0], found[0]);
    const int unsigned_short = 5123;
    const int unsigned_int = 5125;
    EXPECT_EQ(model_["accessors"][1]["componentType"], count == 65535 ? unsigned_short : unsigned_int);
  }
}

TEST_P(GltfWriter, KeepsSeveralMeshesApart) {
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(tetrahedron("iso 0.5"));  // next comes an odd number of triangles, which needs padding
  meshes.push_back(make_mesh("one", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  meshes.push_back(sphere(5, true, "iso 1"));
  meshes.push_back(make_mesh("another", {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {{0, 1, 2}}));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) expect_same_mesh(meshes[m], found[m]);
}

TEST_P(GltfWriter, WritesOriginAsNodeTranslation) {
  const glm::dvec3 origin(1e7 + 1.0 / 3, -123456789.123456789, 1e-17);
  const std::vector<mesh::Mesh> meshes = one(sphere(4, false, "far", origin));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  expect_same_mesh(meshes[0], found[0]);
}

TEST_P(GltfWriter, WritesMinAndMaxOfStoredNumbers) {
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  round_trip(meshes);
  const json& accessor = model_["accessors"][0];
  const std::vector<double> min = {0.0, 0.0, static_cast<double>(-2.0F / 3)};
  const std::vector<double> max = {static_cast<double>(1.0F / 3), static_cast<double>(1e6F / 7),
                                   static_cast<double>(1e-7F)};
  EXPECT_EQ(accessor["min"].get<std::vector<double>>(), min);
  EXPECT_EQ(accessor["max"].get<std::vector<double>>(), max);
}

TEST_P(GltfWriter, SplitsVerticesForFlatNormals) {
  // No triangle uses the last vertex, so it must be in neither the data nor the bounds.
  mesh::Mesh mesh = make_mesh("flat", {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, -3}, {9, 9, 9}}, {{0, 1, 2}, {0, 1, 3}});
  const std::vector<mesh::Mesh> meshes = one(std::move(mesh));
  const auto found = round_trip(meshes, true);
  ASSERT_EQ(found.size(), 1U);
  const std::vector<glm::dvec3> positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {0, 0, -3}};
  const std::vector<glm::vec3> normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}};
  EXPECT_EQ(found[0].positions, positions);
  EXPECT_EQ(found[0].normals, normals);
  EXPECT_EQ(model_["accessors"][0]["min"].get<std::vector<double>>(), (std::vector<double>{0, 0, -3}));
  EXPECT_EQ(model_["accessors"][0]["max"].get<std::vector<double>>(), (std::vector<double>{2, 2, 0}));
  ASSERT_EQ(result_.notes.size(), 1U);
  EXPECT_NE(result_.notes[0].text.find("no welded vertices"), std::string::npos);
}

TEST_P(GltfWriter, WritesEmptySurfaceAsNodeWithoutMesh) {
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(make_mesh("nothing", {}, {}));
  meshes.push_back(tetrahedron("something"));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].name, "nothing");
  EXPECT_TRUE(found[0].positions.empty());
  expect_same_mesh(meshes[1], found[1]);
}

TEST_P(GltfWriter, WritesNoBufferForEmptySurface) {
  const std::vector<mesh::Mesh> meshes = one(make_mesh("nothing", {}, {}));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_FALSE(model_.contains("buffers"));
  EXPECT_FALSE(model_.contains("meshes"));
  EXPECT_FALSE(model_.contains("materials"));
  EXPECT_EQ(folder_.names().size(), 1U);
  EXPECT_EQ(result_.files.size(), 1U);
}

TEST_P(GltfWriter, WritesEmptyNodesAndScenesAsObjects) {
  round_trip(one(make_mesh("", {}, {})));
  EXPECT_TRUE(model_["nodes"][0].is_object());
  round_trip({});
  EXPECT_TRUE(model_["scenes"][0].is_object());
}

TEST_P(GltfWriter, KeepsUnicodeAndQuotesInNames) {
  const std::string name = "Ünïcode \"quoted\" \\ 等値面\n\U0001F480";
  const std::vector<mesh::Mesh> meshes = one(tetrahedron(name));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].name, name);
  EXPECT_TRUE(result_.notes.empty());
}

TEST_P(GltfWriter, ReplacesInvalidUtf8InNamesWithNote) {
  const std::vector<mesh::Mesh> meshes = one(tetrahedron("bad \xFF name"));
  const auto found = round_trip(meshes);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].name, "bad \xEF\xBF\xBD name");
  ASSERT_EQ(result_.notes.size(), 1U);
  EXPECT_NE(result_.notes[0].text.find("UTF-8"), std::string::npos);
}

TEST(GltfWriterFiles, PercentEncodesNameOfDataFile) {
  const TempFolder folder;
  const std::string stem = "kopf 50% #1 ä~_-:";
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  const auto result = must_write(meshes, folder / (stem + ".gltf"), {MeshFormat::gltf, false, false});
  EXPECT_EQ(folder.names(), (std::set<std::string>{stem + ".bin", stem + ".gltf"}));
  const json model = json::parse(read_bytes(folder / (stem + ".gltf")));
  EXPECT_EQ(model["buffers"][0]["uri"], "kopf%2050%25%20%231%20%C3%A4~_-%3A.bin");
  const std::string binary = read_bytes(folder / (stem + ".bin"));
  EXPECT_EQ(model["buffers"][0]["byteLength"], binary.size());
  ASSERT_EQ(result.files.size(), 2U);
  EXPECT_EQ(result.files[0].path, (folder / (stem + ".gltf")).string());
  EXPECT_EQ(result.files[1].bytes, binary.size());
}

TEST(GltfWriterFiles, DescribesWholeBinaryChunkOfGlb) {
  const TempFolder folder;
  const std::vector<mesh::Mesh> meshes = one(sphere(7, true));
  const auto result = must_write(meshes, folder / "a.glb", {});
  const std::string bytes = read_bytes(folder / "a.glb");
  const GlbChunks chunks = take_apart(bytes);
  EXPECT_EQ(chunks.model["buffers"].size(), 1U);
  EXPECT_EQ(chunks.model["buffers"][0]["byteLength"], chunks.binary.size());
  EXPECT_FALSE(chunks.model["buffers"][0].contains("uri"));
  ASSERT_EQ(result.files.size(), 1U);
  EXPECT_EQ(result.files[0].bytes, bytes.size());
}

TEST(GltfWriterFiles, RefusesGlbOfFourGibibytesBeforeWriting) {
  const TempFolder folder;
  mesh::Mesh mesh = make_mesh("large", {{0, 0, 0}}, {});
  mesh.triangles = Buffer<glm::uvec3>(60'000'000);  // 72 bytes each when split; never touched
  const std::vector<mesh::Mesh> meshes = one(std::move(mesh));
  const auto result = write_meshes(meshes, folder / "a.glb", {MeshFormat::glb, true, false}, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::output);
  EXPECT_NE(result.error().message.find("4 GiB"), std::string::npos);
  EXPECT_NE(test::text_of(result.error().hint).find("gltf or ply"), std::string::npos);
  EXPECT_TRUE(folder.names().empty());
}

TEST(GltfWriterFiles, KeepsOldPairIfNewOneFails) {
  const TempFolder folder;
  write_bytes(folder / "a.gltf", "old model");
  fs::create_directory(folder / "a.bin");
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  const auto result = write_meshes(meshes, folder / "a.gltf", {MeshFormat::gltf, false, false}, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::output);
  EXPECT_EQ(read_bytes(folder / "a.gltf"), "old model");
  EXPECT_EQ(folder.names(), (std::set<std::string>{"a.bin", "a.gltf"}));
}

}  // namespace
}  // namespace isoextract::mesh_io

#include "meshes/mesh_writer.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/meshes/written_mesh.hpp"

namespace isoextract::meshes {
namespace {

using namespace test;

TEST(MeshFormats, AreFoundByNameAndExtension) {
  for (const MeshFormatInfo& info : mesh_formats()) {
    EXPECT_EQ(mesh_format_by_name(info.name), info.format);
    EXPECT_EQ(mesh_format_by_path("folder.x/out." + std::string(info.name)), info.format);
    EXPECT_EQ(&mesh_format_info(info.format), &info);
  }
  EXPECT_EQ(mesh_format_by_path("OUT.Glb"), MeshFormat::glb);
  EXPECT_EQ(mesh_format_by_path("out.vtk"), std::nullopt);
  EXPECT_EQ(mesh_format_by_path("glb"), std::nullopt);
  EXPECT_EQ(mesh_format_by_path("-"), std::nullopt);
  EXPECT_EQ(mesh_format_by_name("GLB"), std::nullopt);
}

struct Refusal {
  std::string name;
  MeshFormat format;
  std::size_t meshes;
  bool ascii;
  std::string path;
  std::string hint;
};

class MeshWriterRefusal : public testing::TestWithParam<Refusal> {};

INSTANTIATE_TEST_SUITE_P(All, MeshWriterRefusal,
                         testing::Values(Refusal{"AsciiGlb", MeshFormat::glb, 1, true, "a.glb", "ply, stl"},
                                         Refusal{"AsciiObj", MeshFormat::obj, 1, true, "a.obj", "ply, stl"},
                                         Refusal{"TwoInPly", MeshFormat::ply, 2, false, "a.ply", "glb, gltf, obj"},
                                         Refusal{"TwoInStl", MeshFormat::stl, 2, false, "a.stl", "glb, gltf, obj"},
                                         Refusal{"GltfToStdout", MeshFormat::gltf, 1, false, "-", "glb, ply, obj, stl"},
                                         Refusal{"GltfToDevice", MeshFormat::gltf, 1, false, "/dev/null", "glb"},
                                         Refusal{"GltfNamedBin", MeshFormat::gltf, 1, false, "a.bin", ".gltf"}),
                         [](const auto& test) { return test.param.name; });

TEST_P(MeshWriterRefusal, IsAUsageErrorThatNamesTheRemedy) {
  const Refusal& refusal = GetParam();
  const TempFolder folder;
  std::vector<mesh::Mesh> meshes;
  for (std::size_t m = 0; m < refusal.meshes; ++m) meshes.push_back(tetrahedron());
  const fs::path path = refusal.path.starts_with("a.") ? folder / refusal.path : fs::path(refusal.path);
  const auto result = write_meshes(meshes, path, {refusal.format, false, refusal.ascii});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::usage);
  EXPECT_TRUE(result.error().message.starts_with(path.string() + ": ")) << result.error().message;
  EXPECT_NE(result.error().hint.text.find(refusal.hint), std::string::npos) << result.error().hint.text;
  EXPECT_TRUE(folder.names().empty());
}

// name, options
struct Kind {
  std::string name;
  MeshWriteOptions options;
};

class MeshWriterKind : public testing::TestWithParam<Kind> {};

INSTANTIATE_TEST_SUITE_P(
    All, MeshWriterKind,
    testing::Values(Kind{"glb", {MeshFormat::glb, false, false}}, Kind{"glb_flat", {MeshFormat::glb, true, false}},
                    Kind{"ply", {MeshFormat::ply, false, false}}, Kind{"ply_flat", {MeshFormat::ply, true, false}},
                    Kind{"ply_ascii", {MeshFormat::ply, false, true}}, Kind{"obj", {MeshFormat::obj, false, false}},
                    Kind{"stl", {MeshFormat::stl, false, false}}, Kind{"stl_ascii", {MeshFormat::stl, false, true}}),
    [](const auto& test) { return test.param.name; });

// Large enough for many blocks in every format.
TEST_P(MeshWriterKind, BytesDoNotDependOnTheNumberOfThreads) {
  const TempFolder folder;
  const std::vector<mesh::Mesh> meshes = one(sphere(300, !GetParam().options.flat_normals));
  for (const std::size_t threads : {1U, 8U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    must_write(meshes, folder / std::to_string(threads), GetParam().options);
  }
  const std::string bytes = read_bytes(folder / "1");
  EXPECT_GT(bytes.size(), std::size_t{4} << 20);
  EXPECT_TRUE(bytes == read_bytes(folder / "8"));
}

TEST_P(MeshWriterKind, AFullDeviceIsAnOutputError) {
  const std::vector<mesh::Mesh> meshes = one(sphere(300, !GetParam().options.flat_normals));
  const auto result = write_meshes(meshes, "/dev/full", GetParam().options);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::output);
  EXPECT_EQ(result.error().message, "/dev/full: cannot write: no space left on the device");
}

TEST_P(MeshWriterKind, ASmallMeshFindsAFullDeviceToo) {
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  const auto result = write_meshes(meshes, "/dev/full", GetParam().options);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::output);
}

TEST(MeshWriter, AMissingFolderLeavesNothing) {
  const TempFolder folder;
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  for (const MeshFormatInfo& info : mesh_formats()) {
    const auto result = write_meshes(meshes, folder / "missing/out", {info.format, false, false});
    ASSERT_FALSE(result) << info.name;
    EXPECT_EQ(result.error().kind, ErrorKind::output);
  }
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace isoextract::meshes

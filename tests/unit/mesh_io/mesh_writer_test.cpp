#include "mesh_io/mesh_writer.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "support/hints.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

TEST(MeshFormats, FindsFormatByNameAndExtension) {
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
                                         Refusal{"GltfToStdout", MeshFormat::gltf, 1, false, "-",
                                                 "glb, ply, obj, stl, drc"},
                                         Refusal{"GltfToDevice", MeshFormat::gltf, 1, false, "/dev/null", "glb"},
                                         Refusal{"GltfNamedBin", MeshFormat::gltf, 1, false, "a.bin", ".gltf"}),
                         [](const auto& test) { return test.param.name; });

TEST_P(MeshWriterRefusal, GivesUsageErrorWithRemedy) {
  const Refusal& refusal = GetParam();
  const TempFolder folder;
  std::vector<mesh::Mesh> meshes;
  for (std::size_t m = 0; m < refusal.meshes; ++m) meshes.push_back(tetrahedron());
  const fs::path path = refusal.path.starts_with("a.") ? folder / refusal.path : fs::path(refusal.path);
  const auto result = write_meshes(meshes, path, {refusal.format, false, refusal.ascii}, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::usage);
  EXPECT_TRUE(result.error().message.starts_with(path.string() + ": ")) << result.error().message;
  EXPECT_NE(test::text_of(result.error().hint).find(refusal.hint), std::string::npos)
      << test::text_of(result.error().hint);
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
TEST_P(MeshWriterKind, WritesSameBytesForAnyThreadCount) {
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

TEST_P(MeshWriterKind, GivesOutputErrorOnFullDevice) {
  const std::vector<mesh::Mesh> meshes = one(sphere(300, !GetParam().options.flat_normals));
  const auto result = write_meshes(meshes, "/dev/full", GetParam().options, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::output);
  EXPECT_EQ(result.error().message, "/dev/full: cannot write: no space left on the device");
}

TEST_P(MeshWriterKind, GivesOutputErrorForSmallMeshOnFullDevice) {
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  const auto result = write_meshes(meshes, "/dev/full", GetParam().options, Context());
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::output);
}

TEST(MeshWriter, LeavesNothingIfFolderIsMissing) {
  const TempFolder folder;
  const std::vector<mesh::Mesh> meshes = one(tetrahedron());
  for (const MeshFormatInfo& info : mesh_formats()) {
    const auto result = write_meshes(meshes, folder / "missing/out", {info.format, false, false}, Context());
    ASSERT_FALSE(result) << info.name;
    EXPECT_EQ(result.error().code, ErrorCode::output);
  }
  EXPECT_TRUE(folder.names().empty());
}

const MeshWriteOptions kSeveral[] = {{MeshFormat::glb, false, false},
                                     {MeshFormat::gltf, false, false},
                                     {MeshFormat::gltf, true, false},
                                     {MeshFormat::obj, false, false},
                                     {MeshFormat::obj, true, false}};

TEST(MeshWriter, FreesMeshBeforeNextOne) {
  for (const MeshWriteOptions& options : kSeveral) {
    const MeshFormatInfo& info = mesh_format_info(options.format);
    const TempFolder folder;
    const Context context;
    MeshWriter writer(folder / "out", options, context);
    std::uint64_t held = 0;
    for (const std::uint64_t bytes : {1000U, 20U, 3U}) {
      mesh::Mesh mesh = sphere(8, false);
      mesh.memory = context.reserve(bytes, "a mesh").value();
      ASSERT_TRUE(writer.add(std::move(mesh)));
      held += info.writes_each_mesh_at_once ? 0 : bytes;
      EXPECT_EQ(context.memory().reserved(), held) << info.name;
      EXPECT_FALSE(fs::exists(folder / "out")) << info.name << ": it has its name before it is whole";
    }
    ASSERT_TRUE(writer.finish()) << info.name;
    EXPECT_TRUE(fs::exists(folder / "out"));
  }
}

// A mesh of triangles without common vertices, of `bytes` bytes.
mesh::Mesh large_mesh(std::uint64_t bytes, const std::string& name) {
  mesh::Mesh mesh = tetrahedron(name);
  const std::size_t count = bytes / (3 * sizeof(glm::vec3) + sizeof(glm::uvec3));
  mesh.positions = Buffer<glm::vec3>(3 * count);
  mesh.triangles = Buffer<glm::uvec3>(count);
  for (std::size_t t = 0; t < count; ++t) {
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles[t] = {first, first + 1, first + 2};
    mesh.positions[first] = {static_cast<float>(t), 0, 0};
    mesh.positions[first + 1] = {0, static_cast<float>(t + 1), 0};
    mesh.positions[first + 2] = {0, 1, 2};
  }
  return mesh;
}

// A GLB holds meshes of 64 MiB, and of an eighth of the memory limit.
class LargeMeshes : public testing::TestWithParam<std::uint64_t> {};

INSTANTIATE_TEST_SUITE_P(MeshWriter, LargeMeshes, testing::Values(std::uint64_t{64} << 20U, std::uint64_t{8} << 20U));

TEST_P(LargeMeshes, MoveInGlb) {
  const TempFolder folder;
  const MeshWriteOptions options{.format = MeshFormat::glb, .hash_files = true};
  fs::create_directory(folder / "a");
  fs::create_directory(folder / "b");
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(sphere(9, false));
  meshes.push_back(large_mesh(GetParam(), "large"));
  meshes.push_back(tetrahedron("last", {1e7, 0, 0}));
  const Context context{MemoryBudget(8 * GetParam())};
  MeshWriter writer(folder / "a/out.glb", options, context);
  for (const mesh::Mesh& source : meshes) {
    mesh::Mesh mesh = mesh::copy(source);
    mesh.memory = context.reserve(1000, "a mesh").value();
    ASSERT_TRUE(writer.add(std::move(mesh)));
    // The first mesh is held; the second one is too large to hold both.
    EXPECT_EQ(context.memory().reserved(), &source == &meshes.front() ? 1000U : 0U);
  }
  const auto one_by_one = writer.finish();
  ASSERT_TRUE(one_by_one);
  const MeshWriteResult at_once = must_write(meshes, folder / "b/out.glb", options);
  EXPECT_EQ(one_by_one->files.front().bytes, at_once.files.front().bytes);
  ASSERT_TRUE(at_once.files.front().hash);
  EXPECT_EQ(one_by_one->files.front().hash, at_once.files.front().hash);
  EXPECT_TRUE(read_bytes(folder / "a/out.glb") == read_bytes(folder / "b/out.glb"));
}

void expect_same_bytes_one_by_one_and_together(std::vector<mesh::Mesh> meshes, const MeshWriteOptions& options) {
  const TempFolder folder;
  fs::create_directory(folder / "a");
  fs::create_directory(folder / "b");
  for (mesh::Mesh& mesh : meshes) add_color(mesh, mesh::ComponentType::u8, 3);
  MeshWriter writer(folder / "a/out", options, Context());
  for (const mesh::Mesh& mesh : meshes) ASSERT_TRUE(writer.add(mesh::copy(mesh)));
  const auto one_by_one = writer.finish();
  ASSERT_TRUE(one_by_one);
  const MeshWriteResult at_once = must_write(meshes, folder / "b/out", options);
  EXPECT_EQ(one_by_one->notes, at_once.notes);
  EXPECT_FALSE(at_once.notes.empty());
  ASSERT_EQ(one_by_one->files.size(), at_once.files.size());
  for (std::size_t f = 0; f < at_once.files.size(); ++f) {
    const fs::path path = one_by_one->files[f].path;
    EXPECT_EQ(one_by_one->files[f].bytes, fs::file_size(path));
    EXPECT_TRUE(read_bytes(path) == read_bytes(at_once.files[f].path));
  }
}

TEST(MeshWriter, WritesSameBytesOneByOneAndTogether) {
  for (const MeshWriteOptions& options : kSeveral) {
    SCOPED_TRACE(mesh_format_info(options.format).name);
    std::vector<mesh::Mesh> meshes;
    meshes.push_back(sphere(20, !options.flat_normals));
    meshes.push_back(tetrahedron("not \xff UTF-8", {1e7, 0, 0}));
    meshes.push_back(sphere(9, false));
    expect_same_bytes_one_by_one_and_together(std::move(meshes), options);
  }
}

// The writer frees the arrays of meshes that it holds when it has packed them.
TEST(MeshWriter, WritesSamePackedBytesOneByOneAndTogether) {
  for (const auto& [quantize, compression] :
       {std::pair(true, Compression::none), std::pair(false, Compression::meshopt),
        std::pair(true, Compression::meshopt), std::pair(false, Compression::draco)}) {
    for (const MeshFormat format : {MeshFormat::glb, MeshFormat::gltf}) {
      SCOPED_TRACE(testing::Message() << word_of(compression) << (quantize ? " quantized" : ""));
      MeshWriteOptions options{.format = format};
      options.packing.quantize = quantize;
      options.packing.compression = compression;
      std::vector<mesh::Mesh> meshes;
      meshes.push_back(sphere(20, true));
      meshes.push_back(tetrahedron("not \xff UTF-8"));
      meshes.emplace_back().name = "without triangles";
      meshes.push_back(sphere(9, false));
      expect_same_bytes_one_by_one_and_together(std::move(meshes), options);
    }
  }
}

TEST(MeshWriter, LeavesNothingWithoutFinish) {
  for (const MeshWriteOptions& options : kSeveral) {
    const TempFolder folder;
    {
      MeshWriter writer(folder / "out", options, Context());
      ASSERT_TRUE(writer.add(sphere(300, false)));
    }
    EXPECT_TRUE(folder.names().empty()) << mesh_format_info(options.format).name;
  }
}

TEST(MeshWriter, StaysFailedAfterSecondMeshInSingleMeshFormat) {
  for (const MeshFormat format : {MeshFormat::ply, MeshFormat::stl}) {
    const TempFolder folder;
    MeshWriter writer(folder / "out", {format, false, false}, Context());
    ASSERT_TRUE(writer.add(tetrahedron()));
    const auto second = writer.add(tetrahedron());
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error().code, ErrorCode::usage);
    const auto finished = writer.finish();
    ASSERT_FALSE(finished);
    EXPECT_EQ(finished.error().message, second.error().message);
    EXPECT_TRUE(folder.names().empty());
  }
}

// Bytes sent to a device cannot be removed, so they are written only after every surface has succeeded.
TEST(MeshWriter, WritesNothingToDevicesBeforeFinish) {
  MeshWriter writer("/dev/full", {MeshFormat::obj, false, false}, Context());
  ASSERT_TRUE(writer.add(sphere(300, false)));
  ASSERT_TRUE(writer.add(sphere(300, false)));
  const auto finished = writer.finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::output);
}

}  // namespace
}  // namespace isoextract::mesh_io

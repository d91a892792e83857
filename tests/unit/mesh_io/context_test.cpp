// Reading and writing keep the memory limit and stop when cancelled.
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

TEST(MeshFileContext, KeepsMemoryLimitAndCancellation) {
  const test::TempFolder folder;
  const auto meshes = test::one(test::sphere(20, false));
  for (const MeshFormatInfo& info : mesh_formats()) {
    const auto path = folder / fmt::format("kept.{}", info.name);
    test::must_write(meshes, path, {info.format, false, false});
    const Context context;
    {
      const auto read = read_mesh(path, context);
      ASSERT_TRUE(read) << info.name;
      EXPECT_EQ(context.memory().reserved(), read->mesh.positions.size_bytes() + read->mesh.triangles.size_bytes());
      EXPECT_GT(context.memory().peak(), context.memory().reserved());
      auto bytes = std::filesystem::file_size(path);
      if (info.format == MeshFormat::gltf) bytes += std::filesystem::file_size(folder / "kept.bin");
      EXPECT_GE(context.counters().bytes_read, bytes) << info.name;
    }
    {
      const auto read = read_mesh(path, context, {.normals = true});
      ASSERT_TRUE(read) << info.name;
      EXPECT_EQ(context.memory().reserved(), read->mesh.positions.size_bytes() + read->mesh.triangles.size_bytes() +
                                                 read->normals.values.size_bytes() +
                                                 read->normals.numbers.size_bytes());
    }
    EXPECT_EQ(context.memory().reserved(), 0U);
    context.cancel();
    const auto ended = read_mesh(path, context);
    ASSERT_FALSE(ended) << info.name;
    EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
    const auto written = write_meshes(meshes, path, {info.format, false, false}, context);
    ASSERT_FALSE(written) << info.name;
    EXPECT_EQ(written.error().code, ErrorCode::cancelled);
  }
}

}  // namespace
}  // namespace isoextract::mesh_io

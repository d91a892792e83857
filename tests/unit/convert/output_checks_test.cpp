#include "convert/output_checks.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

TEST(RenameOldMeshes, RenamesBodiesAfterKeptOnes) {
  const test::TempFolder folder;
  const mesh::Mesh mesh = test::make_mesh("a", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  std::vector<mesh_io::WrittenFile> written;
  for (const char* name : {"a_1.ply", "a_2.ply", "a_3.ply"}) {
    const auto done = mesh_io::write_meshes({&mesh, 1}, folder / name, {mesh_io::MeshFormat::ply}, Context());
    ASSERT_TRUE(done) << done.error().message;
    written.push_back(done->files.front());
  }
  const OutputFileJob output{(folder / "a_{piece}.ply").string(), {}};
  const auto renamed = rename_old_meshes(output, mesh_io::MeshFormat::ply, files::InputFileSet(),
                                         std::span(written).first(1), Context());
  ASSERT_TRUE(renamed) << renamed.error().message;
  EXPECT_EQ(*renamed, (std::vector{(folder / "a_2.ply.old").string(), (folder / "a_3.ply.old").string()}));
  EXPECT_TRUE(std::filesystem::exists(folder / "a_1.ply"));
}

}  // namespace
}  // namespace isoextract::convert

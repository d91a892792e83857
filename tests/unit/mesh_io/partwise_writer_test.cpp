// A mesh written part by part, from several threads, has the bytes of a mesh written at once.
#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "support/thread_ranks.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

constexpr unsigned kRings = 260;  // more vertices than 16-bit indices can number

mesh::Mesh head_of(const mesh::Mesh& mesh) {
  mesh::Mesh head;
  head.name = mesh.name;
  head.origin = mesh.origin;
  head.material = mesh.material;
  return head;
}

// Parts of unequal sizes; those of vertices and triangles are independent.
std::vector<mesh::MeshPart> parts_of(const mesh::Mesh& mesh, std::size_t count) {
  std::vector<mesh::MeshPart> parts;
  const auto at = [&](std::size_t size, std::size_t p) { return size * p * p / (count * count); };
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t v = at(mesh.positions.size(), p);
    const std::size_t end_v = at(mesh.positions.size(), p + 1);
    const std::size_t t = at(mesh.triangles.size(), p);
    const std::size_t end_t = at(mesh.triangles.size(), p + 1);
    parts.push_back({v, mesh.positions.span().subspan(v, end_v - v),
                     mesh.normals.empty() ? std::span<const glm::vec3>() : mesh.normals.span().subspan(v, end_v - v), t,
                     mesh.triangles.span().subspan(t, end_t - t)});
  }
  return parts;
}

class PartwiseFile : public testing::TestWithParam<MeshFormat> {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const {
    return folder_ / (name + "." + std::string(mesh_format_info(GetParam()).name));
  }
  [[nodiscard]] Result<bool> begins(const mesh::Mesh& mesh, const MeshWriteOptions& options, const fs::path& path) {
    MeshWriter writer(path, options, Context());
    return writer.begin_parts(head_of(mesh), mesh::shape_of(mesh));
  }

  TempFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Formats, PartwiseFile, testing::Values(MeshFormat::ply, MeshFormat::glb),
                         [](const auto& test) { return std::string(word_of(test.param)); });

TEST_P(PartwiseFile, HasSameBytes) {
  for (const bool normals : {false, true}) {
    mesh::Mesh mesh = sphere(kRings, normals, "a name");
    mesh.material = mesh::Material{glm::dvec3(0.1, 0.2, 0.3), 0.5, true};
    mesh.positions[7].x = -0.1F;  // 17 digits as a double
    const MeshWriteOptions options{.format = GetParam(), .placement = R"({"space":"RAS"})"};
    const std::vector<mesh::Mesh> meshes = one(std::move(mesh));
    (void)must_write(meshes, path("whole"), options);
    MeshWriter writer(path("parts"), options, Context());
    const auto begun = writer.begin_parts(head_of(meshes[0]), mesh::shape_of(meshes[0]));
    ASSERT_TRUE(begun) << begun.error().message;
    ASSERT_TRUE(*begun);
    const auto parts = parts_of(meshes[0], 7);
    for_each_index(parts.size(), [&](std::size_t p) { EXPECT_TRUE(writer.take_part(parts[parts.size() - 1 - p])); });
    const auto done = writer.finish();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->files.at(0).bytes, fs::file_size(path("parts")));
    EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
  }
}

// Parts come in any order, so the writer reads the file back to hash it.
TEST_P(PartwiseFile, HasHashOfItsBytes) {
  const std::vector<mesh::Mesh> meshes = one(sphere(kRings, true, "a name"));
  const MeshWriteOptions options{.format = GetParam(), .hash_files = true};
  const MeshWriteResult whole = must_write(meshes, path("whole"), options);
  MeshWriter writer(path("parts"), options, Context());
  ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), mesh::shape_of(meshes[0])), true);
  const auto parts = parts_of(meshes[0], 5);
  for (std::size_t p = parts.size(); p-- > 0;) ASSERT_TRUE(writer.take_part(parts[p]));
  const auto done = writer.finish();
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
  ASSERT_TRUE(whole.files.at(0).hash.has_value());
  EXPECT_EQ(done->files.at(0).hash, whole.files.at(0).hash);
}

// Rank 0 hashes the bytes of all ranks.
TEST_P(PartwiseFile, HasHashOfTheBytesOfAllRanks) {
  const std::vector<mesh::Mesh> meshes = one(sphere(kRings, true, "a name"));
  const MeshWriteOptions options{.format = GetParam(), .hash_files = true};
  const MeshWriteResult whole = must_write(meshes, path("whole"), options);
  const auto parts = parts_of(meshes[0], kRanks);
  run_ranks([&](Ranks& ranks) {
    MeshWriter writer(path("parts"), options, Context());
    ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), mesh::shape_of(meshes[0]), &ranks), true);
    ASSERT_TRUE(writer.take_part(parts[static_cast<std::size_t>(ranks.rank())]));
    const auto done = writer.finish();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(done->files.at(0).hash, ranks.is_first() ? whole.files.at(0).hash : std::nullopt);
  });
  EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
}

TEST_P(PartwiseFile, LeavesNothingIfNotFinished) {
  const mesh::Mesh mesh = sphere(kRings, false);
  {
    MeshWriter writer(path("out"), {.format = GetParam()}, Context());
    ASSERT_EQ(writer.begin_parts(head_of(mesh), mesh::shape_of(mesh)), true);
    ASSERT_TRUE(writer.take_part(parts_of(mesh, 2)[0]));
  }
  EXPECT_TRUE(folder_.names().empty());
}

TEST_P(PartwiseFile, DeclinesMeshesThatNeedAllOfThem) {
  const mesh::Mesh mesh = sphere(kRings, false);
  const MeshFormat format = GetParam();
  ASSERT_EQ(begins(mesh, {.format = format}, path("out")), true);
  EXPECT_EQ(begins(mesh, {.format = format}, "-"), false);
  EXPECT_EQ(begins(mesh, {.format = format, .flat_normals = true}, path("out")), false);
  EXPECT_EQ(begins(mesh, {.format = MeshFormat::stl}, path("out")), false);
  EXPECT_EQ(begins(sphere(kRings, false, "far", {1e7, 0, 0}), {.format = format}, path("out")), false);
  if (format == MeshFormat::ply) {
    EXPECT_EQ(begins(mesh, {.format = format, .ascii = true}, path("out")), false);
  } else {
    MeshPacking packing;
    packing.compression = Compression::meshopt;
    EXPECT_EQ(begins(mesh, {.format = format, .packing = packing}, path("out")), false);
    EXPECT_EQ(begins(sphere(20, false), {.format = format}, path("out")), false);  // 16-bit indices
  }
}

}  // namespace
}  // namespace isoextract::mesh_io

// A mesh written part by part, from several threads, has the bytes of a mesh written at once.
#include <algorithm>

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

// Early vertices move if the start of the file is shorter or longer than expected.
TEST_P(PartwiseFile, HasSameBytesWithEarlyVertices) {
  for (const bool normals : {false, true}) {
    const std::vector<mesh::Mesh> meshes = one(sphere(kRings, normals, "a name"));
    const MeshWriteOptions options{.format = GetParam(), .hash_files = true};
    const MeshWriteResult whole = must_write(meshes, path("whole"), options);
    const auto parts = parts_of(meshes[0], 7);
    for (const double factor : {0.001, 0.8, 1.0, 1.3, 100.0}) {
      SCOPED_TRACE(factor);
      mesh::MeshShape estimate = mesh::shape_of(meshes[0]);
      estimate.vertices = static_cast<std::uint64_t>(factor * static_cast<double>(estimate.vertices));
      estimate.triangles = static_cast<std::uint64_t>(factor * static_cast<double>(estimate.triangles));
      mesh::Mesh head = head_of(meshes[0]);
      MeshWriter writer(path("parts"), options, Context());
      head.material = mesh::Material{glm::dvec3(0.1, 0.2, 0.3), 0.5, true};  // the later one differs
      const bool is_short = GetParam() == MeshFormat::glb && factor < 0.01;  // its indices have 16 bits
      const bool takes = !is_short && (GetParam() == MeshFormat::ply || !normals);
      ASSERT_EQ(writer.begin_early(std::move(head), estimate), takes);
      const auto is_early = [&](std::size_t p) { return takes && p % 2 == 0; };
      for_each_index(parts.size(), [&](std::size_t p) {
        mesh::MeshPart vertices = parts[p];
        vertices.triangles = {};
        if (is_early(p)) {
          EXPECT_TRUE(writer.take_part(vertices));
        }
      });
      ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), mesh::shape_of(meshes[0])), true);
      for_each_index(parts.size(), [&](std::size_t p) {
        mesh::MeshPart rest = parts[p];
        if (is_early(p)) rest.positions = rest.normals = {};
        EXPECT_TRUE(writer.take_part(rest));
      });
      const auto done = writer.finish();
      ASSERT_TRUE(done) << done.error().message;
      EXPECT_EQ(done->files.at(0).hash, whole.files.at(0).hash);
      EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
    }
  }
}

TEST_P(PartwiseFile, ForgetsEarlyVertices) {
  std::vector<mesh::Mesh> meshes = one(sphere(kRings, false, "a name"));
  const MeshWriteOptions options{.format = GetParam()};
  (void)must_write(meshes, path("whole"), options);
  const mesh::MeshShape shape = mesh::shape_of(meshes[0]);
  {
    MeshWriter writer(path("parts"), options, Context());
    ASSERT_EQ(writer.begin_early(head_of(meshes[0]), shape), true);
    ASSERT_TRUE(writer.take_part({5, meshes[0].positions.span(), {}, 0, {}}));
    ASSERT_TRUE(writer.add(mesh::copy(meshes[0])));
    ASSERT_TRUE(writer.finish());
  }
  EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
  fs::remove(path("parts"));
  {
    MeshWriter writer(path("parts"), options, Context());
    ASSERT_EQ(writer.begin_early(head_of(meshes[0]), shape), true);
    mesh::MeshShape moved = shape;
    moved.origin = {1e7, 0, 0};
    ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), moved), false);
    ASSERT_TRUE(writer.add(std::move(meshes[0])));
    ASSERT_TRUE(writer.finish());
  }
  EXPECT_EQ(read_bytes(path("parts")), read_bytes(path("whole")));
  fs::remove(path("parts"));
  {
    MeshWriter writer(path("parts"), options, Context());
    ASSERT_EQ(writer.begin_early(head_of(sphere(kRings, false)), shape), true);
  }
  EXPECT_FALSE(fs::exists(path("parts")));
  MeshWriter to_stream("-", options, Context());
  EXPECT_EQ(to_stream.begin_early({}, shape), false);
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

TEST_P(PartwiseFile, DeclinesMeshesThatNeedAllParts) {
  const mesh::Mesh mesh = sphere(kRings, false);
  const MeshFormat format = GetParam();
  ASSERT_EQ(begins(mesh, {.format = format}, path("out")), true);
  EXPECT_EQ(begins(mesh, {.format = format}, "-"), true);
  EXPECT_EQ(begins(mesh, {.format = format, .flat_normals = true}, path("out")), format == MeshFormat::ply);
  EXPECT_EQ(begins(mesh, {.format = MeshFormat::drc}, path("out")), false);
  EXPECT_EQ(begins(sphere(kRings, false, "far", {1e7, 0, 0}), {.format = format}, path("out")), false);
  if (format == MeshFormat::glb) {
    MeshPacking packing;
    packing.compression = Compression::meshopt;
    EXPECT_EQ(begins(mesh, {.format = format, .packing = packing}, path("out")), false);
    EXPECT_EQ(begins(mesh, {.format = MeshFormat::gltf, .flat_normals = true}, path("out")), false);
    EXPECT_EQ(begins(sphere(20, false), {.format = format}, path("out")), false);  // 16-bit indices
  }
}

TEST(PartwiseGltf, HasBytesAndHashesOfAWholeMesh) {
  const TempFolder folder;
  fs::create_directory(folder / "whole");
  fs::create_directory(folder / "parts");
  for (const bool normals : {false, true}) {
    const std::vector<mesh::Mesh> meshes = one(sphere(kRings, normals, "a name"));
    const MeshWriteOptions options{.format = MeshFormat::gltf, .hash_files = true};
    const MeshWriteResult whole = must_write(meshes, folder / "whole/a b.gltf", options);
    MeshWriter writer(folder / "parts/a b.gltf", options, Context());
    ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), mesh::shape_of(meshes[0])), true);
    const auto parts = parts_of(meshes[0], 7);
    for_each_index(parts.size(), [&](std::size_t p) { EXPECT_TRUE(writer.take_part(parts[parts.size() - 1 - p])); });
    const auto done = writer.finish();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_EQ(read_bytes(folder / "parts/a b.gltf"), read_bytes(folder / "whole/a b.gltf"));
    EXPECT_TRUE(read_bytes(folder / "parts/a b.bin") == read_bytes(folder / "whole/a b.bin"));
    ASSERT_EQ(done->files.size(), 2);
    for (std::size_t f = 0; f < 2; ++f) {
      ASSERT_TRUE(whole.files[f].hash);
      EXPECT_EQ(done->files[f].hash, whole.files[f].hash);
    }
  }
}

// Formats whose parts are written in order, in one of the passes at least.
const MeshWriteOptions kOrdered[] = {{.format = MeshFormat::ply, .ascii = true},
                                     {.format = MeshFormat::ply, .flat_normals = true},
                                     {.format = MeshFormat::ply, .flat_normals = true, .ascii = true},
                                     {.format = MeshFormat::obj},
                                     {.format = MeshFormat::obj, .flat_normals = true},
                                     {.format = MeshFormat::stl},
                                     {.format = MeshFormat::stl, .ascii = true}};

class OrderedFile : public testing::TestWithParam<MeshWriteOptions> {
 protected:
  static constexpr unsigned kLastVertex = 1 + kRings * 2 * kRings;

  // Triangles are in the order of their first vertices, but for the last two, which refer to far vertices.
  static mesh::Mesh ordered_sphere(bool normals) {
    mesh::Mesh mesh = sphere(kRings, normals, "a name");
    mesh.positions[7].x = -0.1F;
    const auto least = [](const glm::uvec3& t) { return std::min({t.x, t.y, t.z}); };
    std::stable_sort(mesh.triangles.begin(), mesh.triangles.end(),
                     [&](const glm::uvec3& a, const glm::uvec3& b) { return least(a) < least(b); });
    mesh.triangles.end()[-1] = {0, 521, kLastVertex};
    mesh.triangles.end()[-2] = {1500, kLastVertex - 1, 522};
    return mesh;
  }

  // Splits at the rings 1, 2, 100 and 259.
  static std::vector<mesh::MeshPart> parts_of_rings(const mesh::Mesh& mesh) {
    std::vector<mesh::MeshPart> parts;
    std::size_t v = 0;
    std::size_t t = 0;
    for (const std::size_t ring : {1U, 2U, 100U, 259U, 260U}) {
      const std::size_t end_v = ring == kRings ? mesh.positions.size() : 1 + ring * 2 * kRings;
      std::size_t end_t = t;
      while (end_t < mesh.triangles.size()) {
        const glm::uvec3& corners = mesh.triangles[end_t];
        const bool is_last = end_t + 2 >= mesh.triangles.size();
        if (is_last ? ring != kRings : std::min({corners.x, corners.y, corners.z}) >= end_v) break;
        ++end_t;
      }
      parts.push_back({v, mesh.positions.span().subspan(v, end_v - v),
                       mesh.normals.empty() ? std::span<const glm::vec3>() : mesh.normals.span().subspan(v, end_v - v),
                       t, mesh.triangles.span().subspan(t, end_t - t)});
      v = end_v;
      t = end_t;
    }
    return parts;
  }

  static mesh::MeshShape shape_of_parts(const mesh::Mesh& mesh) {
    mesh::MeshShape shape = mesh::shape_of(mesh);
    shape.far_vertices = {0, 521, 522, 1500};
    return shape;
  }

  // Returns the size of the largest positions and the largest triangles of a part.
  static std::uint64_t part_bytes(const mesh::Mesh& mesh) {
    std::uint64_t positions = 0;
    std::uint64_t triangles = 0;
    for (const mesh::MeshPart& part : parts_of_rings(mesh)) {
      positions = std::max<std::uint64_t>(positions, part.positions.size_bytes());
      triangles = std::max<std::uint64_t>(triangles, part.triangles.size_bytes());
    }
    return positions + triangles;
  }

  // Hands over the parts as the passes of the writer ask.
  static void deliver(const MeshWriter& writer, const std::vector<mesh::MeshPart>& parts) {
    const std::vector<mesh::PartPass> passes = writer.part_passes();
    for (std::size_t p = 0; p < passes.size(); ++p) {
      const mesh::PartPass& pass = passes[p];
      ASSERT_TRUE(writer.begin_pass(p));
      for (mesh::MeshPart part : parts) {
        if (!pass.positions) part.positions = {};
        if (!pass.normals) part.normals = {};
        if (!pass.triangles) part.triangles = {};
        ASSERT_TRUE(writer.take_part(part));
      }
    }
  }

  TempFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Formats, OrderedFile, testing::ValuesIn(kOrdered), [](const auto& test) {
  return std::string(word_of(test.param.format)) + (test.param.ascii ? "_text" : "") +
         (test.param.flat_normals ? "_flat" : "");
});

TEST_P(OrderedFile, HasBytesAndHashOfAWholeMesh) {
  for (const bool normals : {false, true}) {
    MeshWriteOptions options = GetParam();
    if (normals && options.flat_normals) continue;
    options.placement = R"({"space":"RAS"})";
    options.hash_files = true;
    const std::vector<mesh::Mesh> meshes = one(ordered_sphere(normals));
    const MeshWriteResult whole = must_write(meshes, folder_ / "whole", options);
    constexpr std::uint64_t kFarBytes = 4 * (sizeof(std::uint32_t) + sizeof(glm::vec3));
    const Context context;
    MeshWriter writer(folder_ / "parts", options, context);
    ASSERT_EQ(writer.begin_parts(head_of(meshes[0]), shape_of_parts(meshes[0])), true);
    deliver(writer, parts_of_rings(meshes[0]));
    const auto done = writer.finish();
    ASSERT_TRUE(done) << done.error().message;
    EXPECT_TRUE(read_bytes(folder_ / "parts") == read_bytes(folder_ / "whole"));
    ASSERT_TRUE(whole.files.at(0).hash);
    EXPECT_EQ(done->files.at(0).hash, whole.files.at(0).hash);
    const bool waits = options.format == MeshFormat::stl || options.flat_normals;
    EXPECT_EQ(context.memory().peak(), waits ? kFarBytes + part_bytes(meshes[0]) : 0);
  }
}

TEST_P(OrderedFile, DeclinesMeshesThatNeedAllParts) {
  const mesh::Mesh mesh = ordered_sphere(true);
  const auto begins = [&](const MeshWriteOptions& options, const mesh::MeshShape& shape, Ranks* ranks = nullptr) {
    MeshWriter writer(folder_ / "out", options, Context());
    return writer.begin_parts(head_of(mesh), shape, ranks);
  };
  MeshWriteOptions options = GetParam();
  mesh::MeshShape shape = shape_of_parts(mesh);
  EXPECT_EQ(begins(options, shape), true);
  options.has_vertex_copies_for_normals = true;
  EXPECT_EQ(begins(options, shape_of_parts(mesh)), options.format != MeshFormat::obj);
  shape = shape_of_parts(mesh);
  shape.origin.x = 1e7;
  EXPECT_EQ(begins(GetParam(), shape), false);
  run_ranks([&](Ranks& ranks) {
    if (!ranks.is_first()) return;
    EXPECT_EQ(begins(GetParam(), shape_of_parts(mesh), &ranks), false);
  });
  EXPECT_TRUE(folder_.names().empty());
}

TEST_P(OrderedFile, LeavesNoFileIfAPartFails) {
  const MeshWriteOptions options = GetParam();
  if (options.format != MeshFormat::stl && !options.flat_normals) return;  // the others reserve no memory
  const mesh::Mesh mesh = ordered_sphere(false);
  const std::vector<mesh::MeshPart> parts = parts_of_rings(mesh);
  const Context context(MemoryBudget(part_bytes(mesh) / 2));
  {
    MeshWriter writer(folder_ / "out", options, context);
    ASSERT_EQ(writer.begin_parts(head_of(mesh), shape_of_parts(mesh)), true);
    const std::size_t pass = options.format == MeshFormat::stl ? 0 : 1;  // parts wait for the next one in this pass
    ASSERT_TRUE(writer.begin_pass(pass));
    Result<void> taken;
    for (std::size_t p = 0; p < parts.size() && taken; ++p) taken = writer.take_part(parts[p]);
    ASSERT_FALSE(taken);
    EXPECT_EQ(taken.error().code, ErrorCode::out_of_memory);
    const Result<void> later[] = {writer.take_part(parts[0]), writer.begin_pass(pass)};
    for (const Result<void>& call : later) {
      ASSERT_FALSE(call);
      EXPECT_EQ(call.error().message, taken.error().message);
    }
    const auto done = writer.finish();
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().message, taken.error().message);
  }
  EXPECT_TRUE(folder_.names().empty());
}

TEST(OrderedFiles, RefuseBinaryStlOfTooManyTriangles) {
  const TempFolder folder;
  MeshWriter writer(folder / "out", {.format = MeshFormat::stl}, Context());
  const auto begun = writer.begin_parts({}, {.triangles = std::uint64_t{1} << 32U});
  ASSERT_FALSE(begun);
  EXPECT_NE(begun.error().message.find("has 4294967296 triangles, binary STL holds at most 4294967295"),
            std::string::npos);
}

}  // namespace
}  // namespace isoextract::mesh_io

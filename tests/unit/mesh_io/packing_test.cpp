// Packed meshes: the reader gets back the mesh within half a step of its lattice.
#include "mesh_io/mesh_packing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/topology.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/mesh_reader_fixture.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using test::must_write;
using test::one;
using test::TempFolder;

struct PackedKind {
  std::string name;
  MeshFormat format;
  MeshPacking packing;

  [[nodiscard]] std::string file() const { return "a." + std::string(mesh_format_info(format).name); }
  [[nodiscard]] MeshWriteOptions options(bool flat = false) const { return {format, flat, false, packing}; }
};

MeshPacking packing_of(Compression compression, bool quantize, double voxel = 0) {
  MeshPacking packing;
  packing.compression = compression;
  packing.quantize = quantize;
  packing.voxel = voxel;
  return packing;
}

std::vector<PackedKind> all_kinds() {
  const MeshPacking draco = packing_of(Compression::draco, false, 0.125);
  MeshPacking bits = packing_of(Compression::draco, false);
  bits.position_bits = 11;
  MeshPacking ordered = packing_of(Compression::meshopt, true, 0.125);
  ordered.optimize_order = true;
  return {{"draco_glb", MeshFormat::glb, draco},
          {"draco_gltf", MeshFormat::gltf, draco},
          {"draco_bits", MeshFormat::glb, bits},
          {"drc", MeshFormat::drc, draco},
          {"quantized", MeshFormat::glb, packing_of(Compression::none, true)},
          {"quantized_gltf", MeshFormat::gltf, packing_of(Compression::none, true, 0.125)},
          {"meshopt", MeshFormat::glb, packing_of(Compression::meshopt, false)},
          {"meshopt_gltf", MeshFormat::gltf, packing_of(Compression::meshopt, false)},
          {"both", MeshFormat::glb, packing_of(Compression::meshopt, true)},
          {"both_ordered", MeshFormat::glb, ordered}};
}

mesh::Mesh must_read(const std::filesystem::path& path) {
  auto read = read_mesh(path, Context());
  if (!read) {
    ADD_FAILURE() << read.error().message;
    return {};
  }
  EXPECT_TRUE(read->is_by_isoextract);
  return std::move(read->mesh);
}

// Checks that every vertex of `found` is within `reach` of a vertex of `mesh` on every axis. Quadratic.
double farthest_vertex(const mesh::Mesh& mesh, const mesh::Mesh& found) {
  double farthest = 0;
  for (std::size_t v = 0; v < found.positions.size(); ++v) {
    double least = 1e300;
    for (std::size_t w = 0; w < mesh.positions.size(); ++w) {
      const glm::dvec3 by = glm::abs(found.position(v) - mesh.position(w));
      least = std::min(least, std::max({by.x, by.y, by.z}));
    }
    farthest = std::max(farthest, least);
  }
  return farthest;
}

class Packing : public testing::TestWithParam<PackedKind> {
 protected:
  TempFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(All, Packing, testing::ValuesIn(all_kinds()),
                         [](const auto& test) { return test.param.name; });

TEST_P(Packing, KeepsTheMeshWithinHalfAStep) {
  const auto meshes = one(test::sphere(12, true));
  const auto result = must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  const mesh::Mesh found = must_read(folder_ / GetParam().file());
  ASSERT_EQ(found.positions.size(), meshes[0].positions.size());
  ASSERT_EQ(found.triangles.size(), meshes[0].triangles.size());
  const mesh::Topology topology = mesh::measure_topology(found);
  EXPECT_EQ(topology.open_edges, 0U);
  EXPECT_EQ(topology.misoriented_edges, 0U);
  EXPECT_EQ(topology.components, 1U);
  EXPECT_GT(mesh::measure_size(found).volume, 4);  // still outward

  ASSERT_EQ(result.packed.size(), 1U);
  const PackedFacts& facts = result.packed[0];
  EXPECT_EQ(facts.positions.has_value(), GetParam().packing.quantizes());
  EXPECT_GT(facts.bytes_before, facts.bytes_after);
  EXPECT_FALSE(facts.used_sequential_method);
  if (!facts.positions) {
    EXPECT_EQ(farthest_vertex(meshes[0], found), 0);
    return;
  }
  EXPECT_GT(facts.positions->largest_axis_move, 0);
  EXPECT_LE(facts.positions->largest_axis_move, facts.positions->step / 2);
  EXPECT_LE(facts.positions->largest_move, std::sqrt(3.0) * facts.positions->largest_axis_move);
  EXPECT_LE(farthest_vertex(meshes[0], found), facts.positions->largest_axis_move * (1 + 1e-12));
  EXPECT_EQ(std::exp2(std::round(std::log2(facts.positions->step))), facts.positions->step);
  if (GetParam().packing.voxel > 0) {
    EXPECT_LE(facts.positions->step, GetParam().packing.voxel / 32);
    EXPECT_GT(facts.positions->step, GetParam().packing.voxel / 64);
  }
  ASSERT_TRUE(facts.largest_normal_angle);
  EXPECT_GT(*facts.largest_normal_angle, 0);
  EXPECT_LT(*facts.largest_normal_angle, 0.6);
}

TEST_P(Packing, WritesSameBytesForAnyThreadCount) {
  const auto meshes = one(test::sphere(60, true));
  std::set<std::string> bytes;
  for (const std::size_t threads : {1U, 8U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    must_write(meshes, folder_ / GetParam().file(), GetParam().options());
    bytes.insert(test::read_bytes(folder_ / GetParam().file()));
  }
  EXPECT_EQ(bytes.size(), 1U);
}

TEST_P(Packing, PacksOneTriangle) {
  const auto meshes = one(test::make_mesh("t", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}));
  must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  EXPECT_EQ(must_read(folder_ / GetParam().file()).triangles.size(), 1U);
}

TEST_P(Packing, KeepsFlatNormalsOfTriangles) {
  const auto meshes = one(test::sphere(12, false));
  const auto result = must_write(meshes, folder_ / GetParam().file(), GetParam().options(true));
  const mesh::Mesh found = must_read(folder_ / GetParam().file());
  EXPECT_EQ(found.triangles.size(), meshes[0].triangles.size());
  EXPECT_EQ(found.positions.size(), meshes[0].positions.size());
  EXPECT_EQ(mesh::measure_topology(found).open_edges, 0U);
  ASSERT_EQ(result.packed.size(), 1U);
  EXPECT_GT(result.packed[0].bytes_before, result.packed[0].bytes_after);
}

TEST_P(Packing, PacksMeshFarFromOrigin) {
  if (GetParam().format == MeshFormat::drc) return;
  const glm::dvec3 far(1e7 + 1.0 / 3, -2e7, 3e6);
  const auto meshes = one(test::sphere(12, true, "far", far));
  const auto result = must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  const mesh::Mesh found = must_read(folder_ / GetParam().file());
  const double axis = result.packed[0].positions ? result.packed[0].positions->largest_axis_move : 0;
  EXPECT_LT(axis, 0.01);
  // The reader applies a node's scale in double and stores float32 relative to another origin.
  EXPECT_LE(farthest_vertex(meshes[0], found), axis + 1e-7);
}

TEST_P(Packing, KeepsColorsAndAttributes) {
  mesh::Mesh mesh = test::sphere(8, true);
  test::add_color(mesh, mesh::ComponentType::u8, 3);
  test::add_attribute(mesh, "heat", mesh::ComponentType::f32, 1);
  test::add_attribute(mesh, "label", mesh::ComponentType::u8, 1);
  test::add_attribute(mesh, "way", mesh::ComponentType::i16, 3, true);
  const auto meshes = one(mesh::copy(mesh));
  must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  const mesh::Mesh found = must_read(folder_ / GetParam().file());
  ASSERT_EQ(found.attributes.size(), mesh.attributes.size());
  // Compares all attribute values of a vertex together, independent of the order of vertices.
  const auto rows = [](const mesh::Mesh& m, const std::vector<std::string>& names) {
    std::multiset<std::string> all;
    for (std::size_t v = 0; v < m.positions.size(); ++v) {
      std::string row;
      for (const std::string& name : names) {
        const auto it = std::ranges::find(m.attributes, name, &mesh::Attribute::name);
        if (it == m.attributes.end()) return all;
        const auto value = it->at(v);
        row.append(reinterpret_cast<const char*>(value.data()), value.size());
      }
      all.insert(row);
    }
    return all;
  };
  const std::vector<std::string> names{"color", "heat", "label", "way"};
  EXPECT_EQ(rows(found, names), rows(mesh, names));
  for (const mesh::Attribute& attribute : mesh.attributes) {
    const auto it = std::ranges::find(found.attributes, attribute.name, &mesh::Attribute::name);
    ASSERT_NE(it, found.attributes.end()) << attribute.name;
    EXPECT_EQ(it->type, attribute.type);
    EXPECT_EQ(it->components, attribute.components);
    EXPECT_EQ(it->normalized, attribute.normalized);
    EXPECT_EQ(it->role, attribute.role);
  }
}

TEST_P(Packing, PacksMeshWithoutTriangles) {
  const auto meshes = one(test::make_mesh("nothing", {}, {}));
  const auto result = write_meshes(meshes, folder_ / GetParam().file(), GetParam().options(), Context());
  if (GetParam().format == MeshFormat::drc) {
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::output);
    EXPECT_TRUE(folder_.names().empty());
    return;
  }
  ASSERT_TRUE(result);
  EXPECT_TRUE(must_read(folder_ / GetParam().file()).triangles.empty());
}

// Three sheets that share an edge, and two cones that share a vertex.
TEST_P(Packing, KeepsNonManifoldMesh) {
  const auto meshes = one(test::make_mesh(
      "sheets", {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, -1, 0}, {2, 0, 0}, {2, 1, 0}, {2, 0, 1}},
      {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}, {2, 5, 6}, {2, 6, 7}}));
  const auto result = must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  const mesh::Mesh found = must_read(folder_ / GetParam().file());
  EXPECT_EQ(found.positions.size(), meshes[0].positions.size());
  EXPECT_EQ(found.triangles.size(), meshes[0].triangles.size());
  EXPECT_EQ(mesh::measure_topology(found).nonmanifold_edges, mesh::measure_topology(meshes[0]).nonmanifold_edges);
  EXPECT_EQ(result.packed[0].used_sequential_method, GetParam().packing.compression == Compression::draco);
}

TEST_P(Packing, KeepsMemoryLimit) {
  const auto meshes = one(test::sphere(60, true));
  const auto result =
      write_meshes(meshes, folder_ / GetParam().file(), GetParam().options(), Context(MemoryBudget(1000)));
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("the limit is"), std::string::npos) << result.error().message;
  EXPECT_TRUE(folder_.names().empty());
}

// Two halves of a surface have different origins. Their shared vertices read back equal to the last bit, and the box
// only decides how many bits are needed.
TEST_P(Packing, KeepsSharedVerticesOfHalvesEqual) {
  PackedKind kind = GetParam();
  if (!kind.packing.quantizes()) return;
  kind.packing.box = mesh::Bounds{{-3, -3, -3}, {3, 3, 3}};
  std::vector<glm::vec3> low;
  std::vector<glm::vec3> high;
  std::vector<glm::uvec3> triangles;
  const glm::dvec3 low_origin(-0.375, 0.25, 0);
  const glm::dvec3 high_origin(1.625, -0.5, 0.75);
  constexpr int kSide = 24;
  for (int j = 0; j <= kSide; ++j) {
    for (int i = 0; i <= 1; ++i) {
      // Multiples of 2^-20, which float32 holds exactly relative to both origins.
      const double y = std::round(std::ldexp(-1 + 2.0 * j / kSide, 20)) * 0x1p-20;
      const double z = std::round(std::ldexp(std::sin(3 * y) / 3, 20)) * 0x1p-20;
      low.emplace_back(glm::dvec3(i - 1.0, y, z) - low_origin);
      high.emplace_back(glm::dvec3(i, y, z) - high_origin);
    }
    if (j == kSide) break;
    const unsigned a = static_cast<unsigned>(2 * j);
    triangles.emplace_back(a, a + 1, a + 3);
    triangles.emplace_back(a, a + 3, a + 2);
  }
  std::array<std::set<std::tuple<double, double, double>>, 2> common;
  for (const int half : {0, 1}) {
    const auto meshes = one(half == 0 ? test::make_mesh("low", low, triangles, {}, low_origin)
                                      : test::make_mesh("high", high, triangles, {}, high_origin));
    must_write(meshes, folder_ / kind.file(), kind.options());
    const mesh::Mesh found = must_read(folder_ / kind.file());
    for (std::size_t v = 0; v < found.positions.size(); ++v) {
      const glm::dvec3 p = found.position(v);
      if (p.x == 0) common[static_cast<std::size_t>(half)].emplace(p.x, p.y, p.z);
    }
  }
  EXPECT_EQ(common[0].size(), static_cast<std::size_t>(kSide + 1));
  EXPECT_EQ(common[0], common[1]);
}

TEST(PackingOptions, RefusesVertexOutsideOfBox) {
  const TempFolder folder;
  for (const PackedKind& kind : all_kinds()) {
    if (!kind.packing.quantizes()) continue;
    MeshWriteOptions options = kind.options();
    options.packing.box = mesh::Bounds{{-1, -1, -1}, {0.5, 1, 1}};
    const auto result = write_meshes(one(test::sphere(8, false)), folder / kind.file(), options, Context());
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, ErrorCode::output);
    EXPECT_TRUE(result.error().message.starts_with((folder / kind.file()).string())) << result.error().message;
    EXPECT_TRUE(folder.names().empty());
  }
}

TEST(PackingOptions, RefusesInvalidOptions) {
  MeshPacking draco = packing_of(Compression::draco, false);
  EXPECT_TRUE(check_packing(draco, MeshFormat::glb));
  EXPECT_TRUE(check_packing(draco, MeshFormat::drc));
  for (const MeshFormat format : {MeshFormat::ply, MeshFormat::obj, MeshFormat::stl}) {
    EXPECT_FALSE(check_packing(draco, format));
    EXPECT_FALSE(check_packing(packing_of(Compression::meshopt, false), format));
    EXPECT_FALSE(check_packing(packing_of(Compression::none, true), format));
    EXPECT_TRUE(check_packing({}, format));
  }
  EXPECT_FALSE(check_packing(packing_of(Compression::none, true), MeshFormat::drc));
  EXPECT_FALSE(check_packing(packing_of(Compression::meshopt, false), MeshFormat::drc));
  EXPECT_FALSE(check_packing(packing_of(Compression::draco, true), MeshFormat::glb));
  EXPECT_TRUE(check_packing(packing_of(Compression::meshopt, true), MeshFormat::glb));
  draco.optimize_order = true;
  EXPECT_FALSE(check_packing(draco, MeshFormat::glb));
  MeshPacking bits = packing_of(Compression::none, true);
  bits.position_bits = 12;
  EXPECT_FALSE(check_packing(bits, MeshFormat::glb));
  bits = packing_of(Compression::draco, false);
  for (const std::uint64_t wrong : {std::uint64_t{0}, kMinPositionBits - 1, kMaxPositionBits + 1}) {
    bits.position_bits = wrong;
    EXPECT_FALSE(check_packing(bits, MeshFormat::glb));
  }
}

TEST(PackingOptions, UsesOneLatticePerFile) {
  const TempFolder folder;
  std::vector<mesh::Mesh> meshes;
  meshes.push_back(test::sphere(8, false, "near"));
  meshes.push_back(test::sphere(8, false, "far", {1000.0 + 1.0 / 3, 0, 0}));
  MeshPacking packing = packing_of(Compression::draco, false);
  packing.position_bits = 16;
  const auto result = must_write(meshes, folder / "a.glb", {MeshFormat::glb, false, false, packing});
  ASSERT_EQ(result.packed.size(), 2U);
  EXPECT_EQ(result.packed[0].positions->step, result.packed[1].positions->step);
  EXPECT_EQ(must_read(folder / "a.glb").triangles.size(), 2 * meshes[0].triangles.size());
}

TEST(PackingOptions, KeepsMeshWhenReordering) {
  const TempFolder folder;
  MeshPacking packing;
  packing.optimize_order = true;
  for (const std::string name : {"glb", "ply", "obj", "stl"}) {
    const MeshFormat format = *mesh_format_by_name(name);
    const auto meshes = one(test::sphere(24, format != MeshFormat::stl));
    must_write(meshes, folder / ("plain." + name), {format, format == MeshFormat::stl, false, {}});
    const auto result =
        must_write(meshes, folder / ("ordered." + name), {format, format == MeshFormat::stl, false, packing});
    EXPECT_TRUE(result.packed.empty());
    EXPECT_NE(test::read_bytes(folder / ("plain." + name)), test::read_bytes(folder / ("ordered." + name)));
    const mesh::Mesh plain = must_read(folder / ("plain." + name));
    const mesh::Mesh ordered = must_read(folder / ("ordered." + name));
    EXPECT_EQ(plain.positions.size(), ordered.positions.size());
    EXPECT_EQ(mesh::measure_topology(ordered).open_edges, 0U);
    EXPECT_NEAR(mesh::measure_size(ordered).volume, mesh::measure_size(plain).volume, 1e-6);
    EXPECT_EQ(farthest_vertex(plain, ordered), 0);
  }
}

// A file that is truncated anywhere or has a changed byte is either read, or refused with a message.
TEST_P(Packing, RefusesDamagedFiles) {
  if (GetParam().format == MeshFormat::gltf) return;
  mesh::Mesh mesh = test::sphere(6, true);
  test::add_color(mesh, mesh::ComponentType::u8, 3);
  const auto meshes = one(std::move(mesh));
  must_write(meshes, folder_ / GetParam().file(), GetParam().options());
  const std::string good = test::read_bytes(folder_ / GetParam().file());
  const auto try_to_read = [&](const std::string& bytes) {
    test::write_bytes(folder_ / GetParam().file(), bytes);
    const auto read = read_mesh(folder_ / GetParam().file(), Context(MemoryBudget(std::uint64_t{64} << 20)));
    if (!read) {
      EXPECT_EQ(read.error().code, ErrorCode::input);
    }
    return read.has_value();
  };
  for (std::size_t length = 0; length < good.size(); length += 61) EXPECT_FALSE(try_to_read(good.substr(0, length)));
  for (std::size_t at = 0; at < good.size(); at += 29) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ static_cast<char>(1 << at % 8));
    (void)try_to_read(bad);
    bad[at] = '\xFF';
    (void)try_to_read(bad);
  }
}

using PackedReader = test::MeshReaderTest;

TEST_F(PackedReader, RefusesInvalidDracoStreams) {
  expect_error("a.drc", "DRA", "expected a Draco file");
  expect_error("a.drc", "DRACO", "expected a Draco bit stream");
  expect_error("a.drc", std::string("DRACO\2\1\1\1\0\0", 11), "of version 2.2, found 2.1");
  expect_error("a.drc", std::string("DRACO\2\2\0\0\0\0", 11), "found a point cloud");
  // Announces 200000 triangles and 200 attributes with seams, for which the corner tables alone take 3 GB.
  const auto edgebreaker = [](char attributes) {
    const std::string counts("\xA0\x8D\x06\xC0\x9A\x0C", 6);  // 100000 vertices, 200000 triangles
    return std::string("DRACO\2\2\1\1\0\0\0", 12) + counts + attributes + std::string(8, '\0');
  };
  const Context limited(MemoryBudget(std::uint64_t{256} << 20));
  test::write_bytes(folder_ / "seams.drc", edgebreaker('\xC8'));
  const auto refused = read_mesh(folder_ / "seams.drc", limited);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit)) << refused.error().message;
  EXPECT_EQ(limited.memory().reserved(), 0U);
  expect_error("a.drc", edgebreaker('\2'), "the Draco bit stream is damaged");
  // Announces four billion triangles.
  expect_error("a.drc", std::string("DRACO\2\2\1\0\0\0\xFF\xFF\xFF\xFF\x0F\xFF\xFF\xFF\xFF\x0F\1", 22), "would take");
}

}  // namespace
}  // namespace isoextract::mesh_io

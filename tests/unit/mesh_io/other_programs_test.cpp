// Mesh files as other programs write them.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <ctime>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh/metrics.hpp"
#include "mesh/topology.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "support/hints.hpp"
#include "support/sample_meshes.hpp"
#include "unit/mesh_io/mesh_reader_fixture.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using test::bytes_of;
using test::gltf;
using test::word;

class OtherProgramsTest : public test::MeshReaderTest {
 protected:
  // All these files hold the tetrahedron with corners at the origin and at 1 on each axis, of volume 1/6.
  static void expect_tetrahedron(const MeshFile& read) {
    EXPECT_EQ(read.mesh.positions.size(), 4U);
    EXPECT_EQ(read.mesh.triangles.size(), 4U);
    EXPECT_TRUE(mesh::measure_topology(read.mesh).is_closed_oriented_manifold());
    EXPECT_NEAR(mesh::measure_size(read.mesh).volume, 1.0 / 6, 1e-6);
  }

  // Returns the only note.
  static void expect_note(const MeshFile& read, const std::string& part) {
    ASSERT_EQ(read.notes.size(), 1U);
    EXPECT_NE(read.notes[0].text.find(part), std::string::npos) << read.notes[0].text;
  }

  // Measures processor time, of which a quadratic algorithm takes minutes. Elapsed time depends on other programs.
  template <class Work>
  static void expect_soon(const Work& work) {
    const std::clock_t start = std::clock();
    work();
    EXPECT_LT((std::clock() - start) / CLOCKS_PER_SEC, 15);
  }
};

constexpr std::array<std::array<float, 9>, 4> kTetrahedron{{{0, 0, 0, 0, 1, 0, 1, 0, 0},
                                                            {0, 0, 0, 1, 0, 0, 0, 0, 1},
                                                            {0, 0, 0, 0, 0, 1, 0, 1, 0},
                                                            {1, 0, 0, 0, 1, 0, 0, 0, 1}}};

constexpr std::string_view kObj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

// Each triangle has its own corners. With `mixed` every second triangle has -0 where the others have 0.
std::string corners(bool mixed) {
  std::string bytes;
  for (std::size_t t = 0; t < kTetrahedron.size(); ++t) {
    for (const float x : kTetrahedron[t]) bytes += bytes_of({mixed && t % 2 == 1 && x == 0 ? -0.0F : x});
  }
  return bytes;
}

std::string binary_stl(const std::string& header, bool mixed = false) {
  std::string bytes = header + std::string(80 - header.size(), ' ') + word(4);
  const std::string all = corners(mixed);
  for (std::size_t t = 0; t < 4; ++t) bytes += std::string(12, '\0') + all.substr(36 * t, 36) + std::string(2, '\0');
  return bytes;
}

std::string text_stl() {
  std::string text = "solid four\n";
  for (const auto& t : kTetrahedron) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (std::size_t c = 0; c < 9; c += 3) text += fmt::format("vertex {} {} {}\n", t[c], t[c + 1], t[c + 2]);
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid four\n";
}

// A model with a .bin file: one primitive, with the given accessors and views.
std::string model(const std::string& primitive, const std::string& accessors, const std::string& views,
                  std::size_t bytes, const std::string& more = "", const std::string& node = R"("mesh":0)") {
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},{}"scenes":[{{"nodes":[0]}}],"nodes":[{{{}}}],"meshes":[{{"primitives":[{{{}}}]}}],)"
      R"("accessors":[{}],"bufferViews":[{}],"buffers":[{{"byteLength":{},"uri":"data.bin"}}]}})",
      more, node, primitive, accessors, views, bytes);
}

TEST_F(OtherProgramsTest, WeldsZerosOfBothSigns) {
  expect_tetrahedron(read_text("a.stl", binary_stl("mixed", true)));
  test::write_bytes(folder_ / "data.bin", corners(true));
  expect_tetrahedron(read_text("a.gltf", model(R"("attributes":{"POSITION":0})",
                                               R"({"bufferView":0,"componentType":5126,"count":12,"type":"VEC3"})",
                                               R"({"buffer":0,"byteLength":144})", 144)));
}

// Two NaNs, with different and with equal bits: refused, without an endless search.
TEST_F(OtherProgramsTest, RefusesNan) {
  std::string bytes = binary_stl("nan");
  for (const unsigned corner : {0U, 1U, 2U}) bytes.replace(84 + 12 + 12 * corner, 4, word(0x7FC00000 + corner / 2));
  expect_error("a.stl", bytes, "expected finite coordinates");
}

TEST_F(OtherProgramsTest, ReadsContinuedObjLines) {
  const std::string obj(kObj);
  expect_tetrahedron(read_text("mark.obj", "\xEF\xBB\xBF" + obj));
  expect_tetrahedron(read_text("old.obj", "# old\r" + replaced(obj, "\n", "\r")));
  expect_tetrahedron(read_text("mixed.obj", "# a\r\n# b\r" + replaced(obj, "f 1 3", "\r\n\rf 1 3")));
  for (const char* end : {"\n", "\r", "\r\n"}) {
    const std::string joined = replaced(replaced(obj, "v 1 0", "v 1 \\\n0"), "f 1 3 2", "f 1 3\\\n\\\n 2 \\ \n");
    expect_tetrahedron(read_text("joined.obj", replaced("# C:\\\n" + joined + "vn 0 0 \\\n1\n", "\n", end)));
  }
  // The error names its line, also if the file ends in a backslash.
  expect_error("a.obj", replaced(obj, "v 1 0 0", "v 1 \\\n\\\nx"), "line 4: expected a number, found 'x'");
  expect_error("a.obj", "v 0 0 \\", "expected a number, found nothing");
  expect_error("a.obj", "v 0 \\0 0\n", "expected a number, found '\\0'");
}

TEST_F(OtherProgramsTest, ReadsPlyWithCarriageReturns) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 4\nproperty list uchar int vertex_index\nend_header\n";
  const std::string body = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
  expect_tetrahedron(read_text("a.ply", replaced(head + body, "\n", "\r")));
  // The first byte of the data is a line feed, which could be taken for part of the line end.
  const std::string binary = replaced(replaced(head, "ascii", "binary_little_endian"), "float", "char");
  std::string data("\n\0\0\1\0\0\0\1\0\0\0\1", 12);
  for (const auto& t : {glm::uvec3(0, 2, 1), glm::uvec3(0, 1, 3), glm::uvec3(0, 3, 2), glm::uvec3(1, 2, 3)}) {
    data += '\3' + word(t.x) + word(t.y) + word(t.z);
  }
  EXPECT_EQ(read_text("b.ply", replaced(binary, "\n", "\r") + data).mesh.position(0), glm::dvec3(10, 0, 0));
}

TEST_F(OtherProgramsTest, ReadsStlInCapitals) {
  std::string text = text_stl();
  expect_tetrahedron(read_text("small.stl", text));
  expect_tetrahedron(read_text("mark.stl", "\xEF\xBB\xBF \n" + text));
  expect_tetrahedron(read_text("old.stl", replaced(text, "\n", "\r")));
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  expect_tetrahedron(read_text("large.stl", text));
  expect_error("a.stl", replaced(text, "ENDSOLID FOUR", ""), "expected 'endsolid'");
  expect_error("a.stl", replaced(text, "VERTEX 1 0 0\n", ""), "expected 3 corners before 'endloop', found '2'");
}

TEST_F(OtherProgramsTest, ReadsStlWithTrailingBytes) {
  for (const char* header : {"any", "solid binary"}) {
    const std::string stl = binary_stl(header);
    EXPECT_TRUE(read_text("a.stl", stl).notes.empty());
    for (const std::size_t more : {1U, 7U, 49U, 512U}) {
      const MeshFile read = read_text("b.stl", stl + std::string(more, 'x'));
      expect_tetrahedron(read);
      expect_note(read, fmt::format("b.stl: the reader skips {} bytes after the last triangle", more));
    }
  }
  // The additional bytes could be triangles, so the count in the header is wrong.
  const std::string stl = binary_stl("any");
  expect_error("c.stl", stl + std::string(50, 'x'),
               "for the 4 triangles that its header announces, found 334 bytes, the size of 5");
  expect_error("c.stl", stl.substr(0, 80) + word(0) + stl.substr(84), "for the 0 triangles");
  expect_error("c.stl", stl.substr(0, 80) + word(0) + "abc", "for the 0 triangles");
}

constexpr const char* kPositions = R"("attributes":{"POSITION":0})";

TEST_F(OtherProgramsTest, ReadsGltfSparseValues) {
  // Replaces the second of three corners, with sparse indices of each size.
  const std::string corners = bytes_of({0, 0, 0, 5, 5, 5, 0, 1, 0});
  const std::string views = R"({"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":4},)"
                            R"({"buffer":0,"byteOffset":40,"byteLength":24})";
  const auto sparse = [&](std::size_t count, int type, const std::string& base) {
    return model(kPositions,
                 fmt::format(R"({{{}"componentType":5126,"count":3,"type":"VEC3","sparse":{{"count":{},"indices":)"
                             R"({{"bufferView":1,"componentType":{}}},"values":{{"bufferView":2}}}}}})",
                             base, count, type),
                 views, 64);
  };
  const std::string base = R"("bufferView":0,)";
  for (const int type : {5121, 5123, 5125}) {
    test::write_bytes(folder_ / "data.bin", corners + word(1) + bytes_of({1, 0, 0, 9, 9, 9}));
    EXPECT_EQ(mesh::measure_size(read_text("a.gltf", sparse(1, type, base)).mesh).area, 0.5) << type;
  }
  // Without a buffer view the other values are zeros.
  test::write_bytes(folder_ / "data.bin", corners + std::string("\0\2\0\0", 4) + bytes_of({3, 0, 0, 0, 4, 0}));
  EXPECT_EQ(mesh::measure_size(read_text("a.gltf", sparse(2, 5121, "")).mesh).area, 6);

  expect_error("b.gltf", sparse(3, 5121, base), "expected a buffer view with room for 3 values, found 24 bytes");
  expect_error("b.gltf", sparse(1, 5126, base), "expected indices of component type 5121, 5123 or 5125, found 5126");
  expect_error("b.gltf", sparse(18446744073709551615U, 5121, base), "values, found 4 bytes");
  test::write_bytes(folder_ / "data.bin", corners + std::string("\2\0\0\0", 4) + bytes_of({3, 0, 0, 0, 4, 0}));
  expect_error("b.gltf", sparse(2, 5121, base),
               "expected increasing indices of sparse values below 3, found 0 at position 1");
  test::write_bytes(folder_ / "data.bin", corners + std::string("\3\0\0\0", 4) + bytes_of({3, 0, 0, 0, 4, 0}));
  expect_error("b.gltf", sparse(1, 5121, base), "expected increasing indices of sparse values below 3, found 3");
}

TEST_F(OtherProgramsTest, ReadsGltfQuantizedPositions) {
  const std::string required = R"("extensionsRequired":["KHR_mesh_quantization"],)";
  const std::string node = R"("mesh":0,"scale":[2,2,4],"translation":[1,1,1])";
  const auto quantized = [&](int type, bool normalized, std::size_t stride, const std::string& more) {
    return model(kPositions,
                 fmt::format(R"({{"bufferView":0,"componentType":{},"normalized":{},"count":3,"type":"VEC3"}})", type,
                             normalized),
                 fmt::format(R"({{"buffer":0,"byteLength":{},"byteStride":{}}})", 3 * stride, stride), 3 * stride, more,
                 node);
  };
  const auto expect_corners = [&](const std::string& text, const std::array<glm::dvec3, 3>& wanted) {
    const mesh::Mesh mesh = read_text("a.gltf", text).mesh;
    ASSERT_EQ(mesh.triangles.size(), 1U);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(glm::length(mesh.position(mesh.triangles[0][c]) - wanted[static_cast<std::size_t>(c)]), 0, 1e-6) << c;
    }
  };
  // Bytes, each vector with one byte of padding: (0, 0, 0), (127, 0, -128), (0, 255 or -1, 0).
  test::write_bytes(folder_ / "data.bin", std::string("\0\0\0\0\177\0\200\0\0\377\0\0", 12));
  expect_corners(quantized(5120, false, 4, required), {{{1, 1, 1}, {255, 1, -511}, {1, -1, 1}}});
  expect_corners(quantized(5120, true, 4, required), {{{1, 1, 1}, {3, 1, -3}, {1, 1 - 2.0 / 127, 1}}});
  expect_corners(quantized(5121, true, 4, required),
                 {{{1, 1, 1}, {1 + 2 * 127.0 / 255, 1, 1 + 4 * 128.0 / 255}, {1, 3, 1}}});
  // (0, 0, 0), (32767, 0, -32768), (0, 65535 or -1, 0).
  test::write_bytes(folder_ / "data.bin",
                    std::string("\0\0\0\0\0\0\0\0\377\177\0\0\0\200\0\0\0\0\377\377\0\0\0\0", 24));
  expect_corners(quantized(5122, true, 8, required), {{{1, 1, 1}, {3, 1, -3}, {1, 1 - 2.0 / 32767, 1}}});
  expect_corners(quantized(5123, false, 8, required), {{{1, 1, 1}, {65535, 1, 131073}, {1, 131071, 1}}});
  expect_error("b.gltf", quantized(5123, false, 8, ""),
               "expected positions of component type 5126 (float; integers only if the file requires "
               "KHR_mesh_quantization), found 5123");
  expect_error("b.gltf", quantized(5125, false, 8, required), "expected");
}

TEST_F(OtherProgramsTest, RefusesUnsupportedRequiredGltfExtensions) {
  const auto requires_all = [](const std::string& names) {
    return replaced(gltf(R"({"mesh":0})"), R"("scenes")", R"("extensionsRequired":[)" + names + R"(],"scenes")");
  };
  for (const char* name : {"KHR_materials_unlit", "KHR_materials_transmission", "KHR_texture_transform",
                           "KHR_texture_basisu", "EXT_texture_webp", "KHR_lights_punctual", "KHR_mesh_quantization",
                           "KHR_draco_mesh_compression", "EXT_meshopt_compression"}) {
    EXPECT_EQ(read_text("a.gltf", requires_all(fmt::format("\"{}\"", name))).mesh.triangles.size(), 1U) << name;
  }
  for (const char* name : {"EXT_mesh_gpu_instancing", "MSFT_lod", "X", ""}) {
    const std::string text = requires_all(fmt::format(R"("KHR_materials_unlit","{}")", name));
    expect_error("a.gltf", text, fmt::format("the required extension \"{}\"", name));
    EXPECT_NE(test::text_of(read_mesh(folder_ / "a.gltf", Context()).error().hint).find("without this extension"),
              std::string::npos);
  }
  expect_error("a.gltf", requires_all("7"), "the required extension 7");
  expect_error("a.gltf", replaced(requires_all(""), "[]", "{}"), "expected a list as 'extensionsRequired'");
}

TEST_F(OtherProgramsTest, ReadsManyJsonValuesInLinearTime) {
  std::string list = "{}";
  for (int i = 0; i < 300000; ++i) list += ",{}";
  const std::string text = replaced(gltf(R"({"mesh":0})"), R"("scenes")", R"("extras":[)" + list + R"(],"scenes")");
  expect_soon([&] { EXPECT_EQ(read_text("a.gltf", text).mesh.triangles.size(), 1U); });
}

// The triangles of a flat polygon with very many corners have its area, its boundary and its winding.
TEST_F(OtherProgramsTest, TriangulatesPolygonsOfManyCorners) {
  for (const unsigned count : {3U, 4U, 15U, 16U, 17U, 18U, 1000U, 64000U}) {
    std::string obj;
    std::string face = "f";
    for (unsigned i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      obj += fmt::format("v {} {} 0\n", std::cos(angle), std::sin(angle));
      face += fmt::format(" {}", i + 1);
    }
    const MeshFile read = read_text("polygon.obj", obj + face + "\n");
    ASSERT_EQ(read.mesh.triangles.size(), count - 2);
    const double area = count / 2.0 * std::sin(2 * std::numbers::pi / count);
    EXPECT_NEAR(mesh::measure_size(read.mesh).area, area, 1e-4) << count;
    const mesh::Topology topology = mesh::measure_topology(read.mesh);
    EXPECT_EQ(topology.open_edges, count);
    EXPECT_EQ(topology.misoriented_edges, 0U);
    EXPECT_EQ(topology.nonmanifold_edges, 0U);
    EXPECT_EQ(topology.euler, 1);
    glm::dvec3 sum(0.0);
    for (const glm::uvec3& t : read.mesh.triangles) {
      const glm::dvec3 p = read.mesh.position(t.x);
      sum += glm::cross(read.mesh.position(t.y) - p, read.mesh.position(t.z) - p) / 2.0;
    }
    EXPECT_NEAR(sum.z, area, 1e-4) << count;
    // No corner belongs to very many triangles, so that a search for the nearest triangle need not visit all.
    std::vector<unsigned> at_corner(count, 0);
    for (const glm::uvec3& t : read.mesh.triangles) {
      for (int c = 0; c < 3; ++c) ++at_corner[t[c]];
    }
    EXPECT_LE(*std::max_element(at_corner.begin(), at_corner.end()), 36U) << count;
  }
}

TEST_F(OtherProgramsTest, FindsGeneratorAndUpAxis) {
  const auto meshes = test::one(test::sphere(4, false));
  for (const MeshFormatInfo& info : mesh_formats()) {
    const bool is_gltf = info.format == MeshFormat::glb || info.format == MeshFormat::gltf;
    const std::string name = fmt::format("ours.{}", info.name);
    test::must_write(meshes, folder_ / name, {info.format, false, false});
    EXPECT_TRUE(must_read(name).is_by_isoextract) << name;
    EXPECT_EQ(must_read(name).y_up, is_gltf) << name;
  }
  EXPECT_FALSE(read_text("a.obj", "# isoextractor\n" + std::string(kObj)).is_by_isoextract);
  EXPECT_FALSE(read_text("a.stl", binary_stl("any")).is_by_isoextract);
  EXPECT_FALSE(read_text("b.stl", text_stl()).is_by_isoextract);
  const MeshFile theirs = read_text("a.gltf", gltf(R"({"mesh":0})"));
  EXPECT_FALSE(theirs.is_by_isoextract);
  EXPECT_TRUE(theirs.y_up);
  EXPECT_FALSE(read_text("a.ply",
                         "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 0\nproperty float x\n"
                         "property float y\nproperty float z\nend_header\n")
                   .is_by_isoextract);
}

}  // namespace
}  // namespace isoextract::mesh_io

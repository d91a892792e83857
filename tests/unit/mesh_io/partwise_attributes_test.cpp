// A mesh with attributes that is written part by part has the bytes and notes of a mesh written at once.
#include <algorithm>
#include <cstring>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

constexpr unsigned kRingsWithAttributes = 260;  // more vertices than 16-bit indices can number
constexpr std::size_t kParts = 7;

// A sphere with attributes of all types and sizes. Two have equal names, and one has an infinite value.
mesh::Mesh sphere_with_attributes(bool normals) {
  using Type = mesh::ComponentType;
  mesh::Mesh mesh = sphere(kRingsWithAttributes, normals, "a name");
  add_attribute(mesh, "temperature", Type::f32, 1);
  add_attribute(mesh, "v", Type::f32, 3);
  add_attribute(mesh, "infinite", Type::f32, 2);
  add_attribute(mesh, "v", Type::u8, 3, true);
  add_attribute(mesh, "id", Type::i32, 1);
  add_attribute(mesh, "exact", Type::f64, 2);
  add_attribute(mesh, "short", Type::i16, 1);
  add_color(mesh, Type::u16, 4);
  const float infinite = std::numeric_limits<float>::infinity();
  std::memcpy(mesh.attributes[2].values.data() + 8000, &infinite, sizeof infinite);
  return mesh;
}

mesh::Mesh head_with_attributes(const mesh::Mesh& mesh) {
  mesh::Mesh head;
  head.name = mesh.name;
  for (const mesh::Attribute& attribute : mesh.attributes) head.attributes.push_back(attribute.without_values());
  return head;
}

// A part and the values of its attributes.
struct PartWithAttributes {
  mesh::MeshPart part;
  std::vector<mesh::Attribute> attributes;
};

std::vector<PartWithAttributes> parts_with_attributes(const mesh::Mesh& mesh) {
  std::vector<PartWithAttributes> parts(kParts);
  const auto at = [](std::size_t size, std::size_t p) { return size * p * p / (kParts * kParts); };
  for (std::size_t p = 0; p < kParts; ++p) {
    const std::size_t v = at(mesh.positions.size(), p);
    const std::size_t vertices = at(mesh.positions.size(), p + 1) - v;
    const std::size_t t = at(mesh.triangles.size(), p);
    mesh::MeshPart& part = parts[p].part;
    part.first_vertex = v;
    part.positions = mesh.positions.span().subspan(v, vertices);
    if (!mesh.normals.empty()) part.normals = mesh.normals.span().subspan(v, vertices);
    part.first_triangle = t;
    part.triangles = mesh.triangles.span().subspan(t, at(mesh.triangles.size(), p + 1) - t);
    for (const mesh::Attribute& attribute : mesh.attributes) {
      mesh::Attribute& values = parts[p].attributes.emplace_back(attribute.without_values());
      values.values = Buffer<std::byte>(vertices * attribute.stride());
      std::copy_n(attribute.values.data() + v * attribute.stride(), values.values.size(), values.values.data());
    }
    part.attributes = parts[p].attributes;
  }
  return parts;
}

class PartwiseAttributesFile : public testing::TestWithParam<MeshWriteOptions> {
 protected:
  // Hands over the parts as the passes of the writer ask; in passes without order, from the last one, in parallel.
  static void deliver(const MeshWriter& writer, const std::vector<PartWithAttributes>& parts) {
    const std::vector<mesh::PartPass> passes = writer.part_passes();
    for (std::size_t p = 0; p < passes.size(); ++p) {
      const mesh::PartPass& pass = passes[p];
      ASSERT_TRUE(writer.begin_pass(p));
      const auto take = [&](mesh::MeshPart part) {
        if (!pass.positions) part.positions = {};
        if (!pass.normals) part.normals = {};
        if (!pass.triangles) part.triangles = {};
        if (!pass.attributes) part.attributes = {};
        EXPECT_TRUE(writer.take_part(part));
      };
      for (std::size_t i = 0; i < parts.size() && pass.in_order; ++i) take(parts[i].part);
      if (!pass.in_order) {
        for_each_index(parts.size(), [&](std::size_t i) { take(parts[parts.size() - 1 - i].part); });
      }
    }
  }

  TempFolder folder_;
};
INSTANTIATE_TEST_SUITE_P(Formats, PartwiseAttributesFile,
                         testing::Values(MeshWriteOptions{.format = MeshFormat::ply},
                                         MeshWriteOptions{.format = MeshFormat::ply, .ascii = true},
                                         MeshWriteOptions{.format = MeshFormat::glb},
                                         MeshWriteOptions{.format = MeshFormat::gltf}),
                         [](const auto& test) {
                           return std::string(word_of(test.param.format)) + (test.param.ascii ? "_text" : "");
                         });

TEST_P(PartwiseAttributesFile, HasBytesAndNotesOfAWholeMesh) {
  for (const bool normals : {false, true}) {
    const MeshWriteOptions options = GetParam();
    const mesh::Mesh mesh = sphere_with_attributes(normals);
    const std::string name = "a." + std::string(word_of(options.format));
    std::filesystem::create_directories(folder_ / "whole");
    std::filesystem::create_directories(folder_ / "parts");
    const MeshWriteResult whole = must_write(std::span(&mesh, 1), folder_ / ("whole/" + name), options);
    mesh::MeshShape shape = mesh::shape_of(mesh);
    shape.not_finite_attributes = {2};
    MeshWriter writer(folder_ / ("parts/" + name), options, Context());
    ASSERT_EQ(writer.begin_parts(head_with_attributes(mesh), shape), true);
    deliver(writer, parts_with_attributes(mesh));
    const auto done = writer.finish();
    ASSERT_TRUE(done) << done.error().message;
    for (const WrittenFile& file : done->files) {
      const std::string written = std::filesystem::path(file.path).filename().string();
      EXPECT_TRUE(read_bytes(folder_ / ("parts/" + written)) == read_bytes(folder_ / ("whole/" + written))) << written;
    }
    ASSERT_EQ(done->notes.size(), whole.notes.size());
    EXPECT_GE(done->notes.size(), is_gltf(options.format) ? 4U : 2U);
    for (std::size_t n = 0; n < done->notes.size(); ++n) EXPECT_EQ(done->notes[n].text, whole.notes[n].text);
  }
}

TEST(PartwiseAttributes, AreDeclinedByFormatsThatCannotStoreThem) {
  const TempFolder folder;
  const mesh::Mesh mesh = sphere_with_attributes(false);
  for (const MeshFormat format : {MeshFormat::obj, MeshFormat::stl}) {
    MeshWriter writer(folder / "out", {.format = format}, Context());
    EXPECT_EQ(writer.begin_parts(head_with_attributes(mesh), mesh::shape_of(mesh)), false);
  }
}

}  // namespace
}  // namespace isoextract::mesh_io

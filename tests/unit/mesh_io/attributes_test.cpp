// Writes vertex attributes and reads them back.
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh_io/mesh_reader.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;
using mesh::ComponentType;

struct Form {
  std::string_view name;
  MeshWriteOptions options;
};

class AttributeTest : public testing::Test {
 protected:
  MeshWriteResult write(mesh::Mesh mesh, const Form& form) {
    const auto meshes = one(std::move(mesh));
    return must_write(meshes, folder_ / std::string(form.name), form.options);
  }
  MeshFile read(std::string_view name) {
    auto file = read_mesh(folder_ / std::string(name), Context());
    if (!file) throw std::runtime_error(file.error().message);
    return std::move(*file);
  }
  void expect_error(const std::string& name, const std::string& bytes, const std::string& part) {
    write_bytes(folder_ / name, bytes);
    const auto file = read_mesh(folder_ / name, Context());
    ASSERT_FALSE(file) << part;
    EXPECT_NE(file.error().message.find(part), std::string::npos) << file.error().message;
  }

  TempFolder folder_;
};

constexpr std::array kForms{
    Form{"a.ply", {MeshFormat::ply, false, false}},    Form{"ascii.ply", {MeshFormat::ply, false, true}},
    Form{"flat.ply", {MeshFormat::ply, true, false}},  Form{"a.glb", {MeshFormat::glb, false, false}},
    Form{"flat.glb", {MeshFormat::glb, true, false}},  Form{"a.gltf", {MeshFormat::gltf, false, false}},
    Form{"flat.gltf", {MeshFormat::gltf, true, false}}};

bool is_gltf(const Form& form) {
  return form.options.format == MeshFormat::glb || form.options.format == MeshFormat::gltf;
}

// Compares attributes corner by corner, since vertices may be reordered.
void expect_same_corners(const mesh::Mesh& found, const mesh::Mesh& expected) {
  ASSERT_EQ(found.attributes.size(), expected.attributes.size());
  ASSERT_EQ(found.triangles.size(), expected.triangles.size());
  for (const mesh::Attribute& wanted : expected.attributes) {
    const auto is = std::ranges::find(found.attributes, wanted.name, &mesh::Attribute::name);
    ASSERT_NE(is, found.attributes.end()) << wanted.name;
    EXPECT_EQ(is->role, wanted.role);
    EXPECT_EQ(is->type, wanted.type) << wanted.name;
    EXPECT_EQ(is->components, wanted.components) << wanted.name;
    EXPECT_EQ(is->normalized, wanted.normalized) << wanted.name;
    ASSERT_EQ(is->values.size(), found.positions.size() * wanted.stride());
    bool same = true;
    for (std::size_t t = 0; t < found.triangles.size(); ++t) {
      for (int c = 0; c < 3; ++c) {
        same = same && std::ranges::equal(is->at(found.triangles[t][c]), wanted.at(expected.triangles[t][c]));
      }
    }
    EXPECT_TRUE(same) << wanted.name;
  }
}

TEST_F(AttributeTest, ReadsBackEveryType) {
  for (const Form& form : kForms) {
    for (const bool normals : {false, true}) {
      if (normals && form.options.flat_normals) continue;
      for (std::size_t components = 1; components <= mesh::kMaxComponents; ++components) {
        mesh::Mesh mesh = sphere(5, normals);
        for (const ComponentType type :
             {ComponentType::i8, ComponentType::u8, ComponentType::i16, ComponentType::u16, ComponentType::i32,
              ComponentType::u32, ComponentType::f32, ComponentType::f64}) {
          const bool wide = type == ComponentType::i32 || type == ComponentType::u32 || type == ComponentType::f64;
          if (wide && is_gltf(form)) continue;
          add_attribute(mesh, fmt::format("Of_{}", component_name(type)), type, components);
        }
        if (is_gltf(form)) add_attribute(mesh, "fraction", ComponentType::i16, components, true);
        SCOPED_TRACE(fmt::format("{} {} {}", form.name, normals, components));
        const auto written = write(copy(mesh), form);
        const MeshFile file = read(form.name);
        EXPECT_TRUE(file.notes.empty());
        EXPECT_EQ(written.notes.size(), form.options.flat_normals && is_gltf(form) ? 1U : 0U);
        expect_same_corners(file.mesh, mesh);
      }
    }
  }
}

TEST_F(AttributeTest, ReadsBackColors) {
  for (const Form& form : kForms) {
    for (const ComponentType type : {ComponentType::u8, ComponentType::u16, ComponentType::f32}) {
      for (const std::size_t components : {3U, 4U}) {
        SCOPED_TRACE(fmt::format("{} {} {}", form.name, component_name(type), components));
        mesh::Mesh mesh = sphere(5, false, "far", {1e7 + 0.5, -3e7, 5});
        add_attribute(mesh, "before", ComponentType::u8, 1);
        add_color(mesh, type, components);
        write(copy(mesh), form);
        expect_same_corners(read(form.name).mesh, mesh);
      }
    }
  }
}

TEST_F(AttributeTest, UsesCommonPlyNames) {
  mesh::Mesh mesh = tetrahedron();
  add_color(mesh, ComponentType::u8, 4);
  add_attribute(mesh, "quality", ComponentType::f32, 1);
  add_attribute(mesh, "way", ComponentType::i32, 2);
  write(std::move(mesh), kForms[0]);
  const std::string bytes = read_bytes(folder_ / "a.ply");
  EXPECT_NE(bytes.find("property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
                       "property uchar alpha\nproperty float quality\nproperty int way_0\nproperty int way_1\n"
                       "element face"),
            std::string::npos);
}

TEST_F(AttributeTest, ReplacesUnsupportedNames) {
  mesh::Mesh mesh = tetrahedron();
  for (const char* name : {"two words", "x", "red", "same", "same", "", "\xFF"}) {
    add_attribute(mesh, name, ComponentType::u8, 1);
  }
  add_color(mesh, ComponentType::u8, 3);
  const auto names = [](const mesh::Mesh& found) {
    std::vector<std::string> all;
    for (const mesh::Attribute& attribute : found.attributes) all.push_back(attribute.name);
    std::ranges::sort(all);
    return all;
  };
  EXPECT_EQ(write(copy(mesh), kForms[0]).notes.size(), 6U);
  EXPECT_EQ(names(read("a.ply").mesh),
            (std::vector<std::string>{"_", "attribute", "color", "red_", "same", "same_", "two_words", "x_"}));
  EXPECT_EQ(write(copy(mesh), kForms[3]).notes.size(), 2U);
  EXPECT_EQ(names(read("a.glb").mesh),
            (std::vector<std::string>{"", "color", "red", "same", "same_", "two words", "x", "\xEF\xBF\xBD"}));
}

TEST_F(AttributeTest, NotesUnsupportedAttributes) {
  mesh::Mesh mesh = tetrahedron();
  add_attribute(mesh, "wide", ComponentType::f64, 1);
  add_attribute(mesh, "nan", ComponentType::f32, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(mesh.attributes[1].values.data() + 4, &nan, sizeof nan);
  add_attribute(mesh, "fraction", ComponentType::u8, 1, true);
  const auto gltf = write(copy(mesh), kForms[3]);
  ASSERT_EQ(gltf.notes.size(), 2U);
  EXPECT_NE(gltf.notes[0].text.find("f64: the writer omits 'wide'"), std::string::npos) << gltf.notes[0].text;
  EXPECT_NE(gltf.notes[1].text.find("'nan'"), std::string::npos) << gltf.notes[1].text;
  EXPECT_EQ(read("a.glb").mesh.attributes.size(), 1U);
  const auto ply = write(copy(mesh), kForms[1]);
  ASSERT_EQ(ply.notes.size(), 1U);
  EXPECT_NE(ply.notes[0].text.find("'fraction'"), std::string::npos) << ply.notes[0].text;
  const mesh::Mesh back = read("ascii.ply").mesh;
  ASSERT_EQ(back.attributes.size(), 3U);
  float second = 0;
  std::memcpy(&second, back.attributes[1].values.data() + 4, sizeof second);
  EXPECT_TRUE(std::isnan(second));
  for (const Form& form :
       {Form{"a.obj", {MeshFormat::obj, false, false}}, Form{"a.stl", {MeshFormat::stl, false, false}}}) {
    const auto written = write(copy(mesh), form);
    ASSERT_EQ(written.notes.size(), 1U);
    EXPECT_NE(
        written.notes[0].text.find("the writer omits 'wide', 'nan', 'fraction'; glb, gltf, ply, drc store attributes"),
        std::string::npos)
        << written.notes[0].text;
    EXPECT_TRUE(read(form.name).mesh.attributes.empty());
  }
}

constexpr const char* kPlyEnd =
    "property float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar uint vertex_indices\n"
    "end_header\n";

TEST_F(AttributeTest, ReadsPlyPropertiesOfOtherPrograms) {
  const auto ply = [&](const std::string& properties, const std::string& values) {
    write_bytes(folder_ / "in.ply", "ply\nformat ascii 1.0\nelement vertex 3\n" + properties + kPlyEnd + values +
                                        " 0 0 0\n" + values + " 1 0 0\n" + values + " 0 1 0\n3 0 1 2\n");
    return read("in.ply");
  };
  // red, green and blue form no color if their types differ or one is missing.
  EXPECT_EQ(ply("property uchar red\nproperty uchar green\nproperty float blue\n", "1 2 3").mesh.attributes.size(), 3U);
  EXPECT_EQ(ply("property int red\nproperty int green\nproperty int blue\n", "1 2 3").mesh.attributes.size(), 3U);
  EXPECT_EQ(ply("property uchar red\nproperty uchar green\n", "1 2").mesh.attributes.size(), 2U);
  const MeshFile color =
      ply("property uchar blue\nproperty uchar green\nproperty float alpha\nproperty uchar red\n", "3 2 0.5 1");
  ASSERT_EQ(color.mesh.attributes.size(), 2U);
  EXPECT_EQ(color.mesh.attributes[0].role, mesh::AttributeRole::color);
  EXPECT_EQ(color.mesh.attributes[0].at(2)[0], std::byte{1});
  EXPECT_EQ(color.mesh.attributes[1].name, "alpha");
  // More than four numbered properties become separate attributes.
  std::string properties;
  for (int i = 0; i < 5; ++i) properties += fmt::format("property short f_{}\n", i);
  EXPECT_EQ(ply(properties, "1 2 3 4 5").mesh.attributes.size(), 5U);
  EXPECT_TRUE(ply("property float nx\nproperty float ny\nproperty float nz\n", "1 0 0").mesh.attributes.empty());
  const MeshFile list = ply("property list uchar int ring\n", "2 5 6");
  EXPECT_TRUE(list.mesh.attributes.empty());
  ASSERT_EQ(list.notes.size(), 1U);
  EXPECT_NE(list.notes[0].text.find("'ring'"), std::string::npos);
}

TEST_F(AttributeTest, RefusesDamagedPly) {
  const auto ply = [&](const std::string& type, const std::string& value) {
    return "ply\nformat ascii 1.0\nelement vertex 1\nproperty " + type + " q\n" + kPlyEnd + value + " 0 0 0\n";
  };
  expect_error("d.ply", ply("uchar", "256"),
               "expected a value of type uchar for the property 'q' of vertex 0, found 256");
  expect_error("d.ply", ply("int", "1.5"), "type int for the property 'q'");
  expect_error("d.ply", ply("uint", "-1"), "type uint for the property 'q'");
  expect_error("d.ply", ply("float", "1e300"), "type float for the property 'q'");
  expect_error("d.ply",
               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n"
               "element vertex 1\nproperty uchar q\n" +
                   std::string(kPlyEnd) + "0 0 0\n1 0 0 0\n3 0 0 0\n",
               "expected a value of 'q' for each of 2 vertices, found 1 values");
}

class GltfAttributeTest : public AttributeTest {
 protected:
  // Two triangles over one buffer of zeros; `first` and `second` are attributes beside POSITION.
  std::string gltf(const std::string& first, const std::string& second, const std::string& accessors,
                   std::size_t views = 64) {
    write_bytes(folder_ / "zeros.bin", std::string(64, '\0'));
    const auto primitive = [](const std::string& more) {
      return R"({"attributes":{"POSITION":0)" + (more.empty() ? "" : "," + more) + "}}";
    };
    return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
           primitive(first) + (second == "none" ? "" : "," + primitive(second)) +
           R"(]}],"buffers":[{"byteLength":64,"uri":"zeros.bin"}],"bufferViews":[{"buffer":0,"byteLength":)" +
           std::to_string(views) + R"(}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)" +
           accessors + "]}";
  }
};

constexpr const char* kBytes = R"({"bufferView":0,"componentType":5121,"count":3,"type":"SCALAR"})";

TEST_F(GltfAttributeTest, KeepsAttributesThatAllSurfacesHave) {
  const auto notes = [&](const std::string& first, const std::string& second, std::size_t attributes) {
    write_bytes(folder_ / "a.gltf",
                gltf(first, second,
                     std::string(kBytes) + R"(,{"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR"})"));
    const MeshFile file = read("a.gltf");
    EXPECT_EQ(file.mesh.attributes.size(), attributes);
    for (const mesh::Attribute& attribute : file.mesh.attributes) {
      EXPECT_EQ(attribute.values.size(), file.mesh.positions.size() * attribute.stride());
    }
    return file.notes.size();
  };
  EXPECT_EQ(notes(R"("_A":1,"TEXCOORD_0":1)", R"("_A":1)", 1), 0U);
  EXPECT_EQ(notes(R"("_A":1,"_B":1)", R"("_B":1)", 1), 1U);
  EXPECT_EQ(notes(R"("_A":1)", R"("_A":2)", 0), 1U);
  EXPECT_EQ(notes("", R"("_A":1)", 0), 1U);
}

TEST_F(GltfAttributeTest, NotesWeldedCornersWithOtherValues) {
  std::string bytes(64, '\0');
  bytes[38] = 7;  // of the third corner; all corners have equal positions
  const std::string model =
      gltf(R"("_A":1)", "none", R"({"bufferView":0,"byteOffset":36,"componentType":5121,"count":3,"type":"SCALAR"})");
  write_bytes(folder_ / "zeros.bin", bytes);
  write_bytes(folder_ / "a.gltf", model);
  const MeshFile file = read("a.gltf");
  EXPECT_EQ(file.mesh.positions.size(), 1U);
  ASSERT_EQ(file.notes.size(), 1U);
  EXPECT_NE(file.notes[0].text.find("the reader merges 1 corners"), std::string::npos) << file.notes[0].text;
}

TEST_F(GltfAttributeTest, RefusesDamagedGltf) {
  const auto damaged = [&](const std::string& attributes, const std::string& accessor, const std::string& part) {
    expect_error("d.gltf", gltf(attributes, "none", accessor), part);
  };
  damaged(R"("_A":1)", R"({"bufferView":0,"componentType":5121,"count":2,"type":"SCALAR"})",
          "expected 3 values of '_A', one per vertex, found 2");
  damaged(R"("_A":1)", R"({"bufferView":0,"componentType":5121,"byteOffset":62,"count":3,"type":"SCALAR"})",
          "expected a buffer view with room for 3 values, found 64 bytes");
  damaged(R"("_A":1)", R"({"bufferView":0,"componentType":5124,"count":3,"type":"SCALAR"})",
          "expected component type 5120, 5121, 5122, 5123, 5125 or 5126 of");
  damaged(R"("_A":7)", kBytes, "expected an index of one of the 2 entries of 'accessors'");
  damaged(R"("_A":"x")", kBytes, "expected an accessor as '_A'");
  damaged(R"("COLOR_0":1)", kBytes, "expected colors with three or four components");
  damaged(R"("COLOR_0":1)", R"({"bufferView":0,"componentType":5121,"count":3,"type":"VEC3"})",
          "expected colors with three or four components");
  // glTF allows an accessor without values, but the reader refuses it.
  write_bytes(folder_ / "a.gltf", gltf(R"("_A":1)", "none", R"({"componentType":5121,"count":3,"type":"SCALAR"})"));
  EXPECT_EQ(read("a.gltf").notes.size(), 1U);
}

}  // namespace
}  // namespace isoextract::mesh_io

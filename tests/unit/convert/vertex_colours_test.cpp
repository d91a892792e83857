#include "convert/stages/vertex_colours.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "convert/attribute_source.hpp"
#include "edit/colormap.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::convert {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

mesh::Mesh with_values(const std::vector<float>& values, std::size_t components = 1) {
  mesh::Mesh mesh;
  mesh.positions = Buffer<glm::vec3>(values.size() / components);
  mesh::Attribute attribute;
  attribute.name = "heat";
  attribute.components = components;
  attribute.values = Buffer<std::byte>(values.size() * sizeof(float));
  if (!values.empty()) std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
  mesh.attributes.push_back(std::move(attribute));
  return mesh;
}

template <class T>
std::vector<T> colours_of(const mesh::Mesh& mesh) {
  const mesh::Attribute& colours = mesh.attributes.back();
  std::vector<T> numbers(colours.values.size() / sizeof(T));
  if (!numbers.empty()) std::memcpy(numbers.data(), colours.values.data(), colours.values.size());
  return numbers;
}

ColourChoice by_heat(edit::Colormap map = edit::Colormap::gray, std::optional<std::array<double, 2>> range = {}) {
  return {"heat", map, range};
}

TEST(VertexColours, GltfIsLinearAndPlyIsSrgb) {
  mesh::Mesh mesh = with_values({0, 1, 0.5});
  const auto record = add_colours(by_heat(), mesh_io::MeshFormat::glb, mesh, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->range, (std::array{0.0, 1.0}));
  EXPECT_EQ(mesh.attributes.back().type, mesh::ComponentType::u16);
  EXPECT_TRUE(mesh.attributes.back().normalised);
  const auto linear = colours_of<std::uint16_t>(mesh);
  EXPECT_EQ((std::vector(linear.begin(), linear.begin() + 8)),
            (std::vector<std::uint16_t>{0, 0, 0, 65535, 65535, 65535, 65535, 65535}));
  EXPECT_NEAR(linear[8], 65535 * 0.2140, 150);  // the middle of sRGB

  mesh::Mesh other = with_values({0, 1, 0.5});
  ASSERT_TRUE(add_colours(by_heat(), mesh_io::MeshFormat::ply, other, Context()));
  EXPECT_EQ(colours_of<std::uint8_t>(other), (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 128, 128, 128}));
}

TEST(VertexColours, RangesLengthsAndNumbersThatAreNone) {
  mesh::Mesh mesh = with_values({kNan, 5, 10, std::numeric_limits<float>::infinity()});
  auto record =
      add_colours(by_heat(edit::Colormap::gray, std::array{0.0, 10.0}), mesh_io::MeshFormat::ply, mesh, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->not_numbers, 1U);
  const auto grey = colours_of<std::uint8_t>(mesh);
  EXPECT_EQ((std::array{grey[0], grey[3], grey[6], grey[9]}), (std::array<std::uint8_t, 4>{128, 128, 255, 255}));

  mesh::Mesh vectors = with_values({3, 4, 0, 0, 0, 0, 0, -5, 12}, 3);
  record = add_colours(by_heat(), mesh_io::MeshFormat::ply, vectors, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->range, (std::array{0.0, 13.0}));

  mesh::Mesh high = with_values({4, 8, 6});
  ASSERT_TRUE(add_colours(by_heat(), mesh_io::MeshFormat::ply, high, Context()));
  EXPECT_EQ(colours_of<std::uint8_t>(high), (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 128, 128, 128}));
  mesh::Mesh given = with_values({4, 8, 1});
  ASSERT_TRUE(
      add_colours(by_heat(edit::Colormap::gray, std::array{2.0, 6.0}), mesh_io::MeshFormat::ply, given, Context()));
  EXPECT_EQ(colours_of<std::uint8_t>(given), (std::vector<std::uint8_t>{128, 128, 128, 255, 255, 255, 0, 0, 0}));

  mesh::Mesh alike = with_values({2, 2});
  ASSERT_TRUE(add_colours(by_heat(), mesh_io::MeshFormat::ply, alike, Context()));
  EXPECT_EQ(colours_of<std::uint8_t>(alike).front(), 128);

  mesh::Mesh none = with_values({});
  ASSERT_TRUE(add_colours(by_heat(), mesh_io::MeshFormat::ply, none, Context()));
  EXPECT_FALSE(add_colours(by_heat(), mesh_io::MeshFormat::ply, mesh, Context{MemoryBudget(1)}));
}

TEST(Materials, OuterSurfacesLetInnerOnesBeSeen) {
  ConversionJob job;
  std::vector<double> isos{1, 3, 2};
  EXPECT_FALSE(material_of(job, isos, 1, field::FieldKind::density));
  job.colour = ColourChoice{{}, edit::Colormap::gray, {}};
  const auto opacity = [&](double iso, field::FieldKind kind) { return material_of(job, isos, iso, kind)->opacity; };
  EXPECT_EQ(opacity(1, field::FieldKind::density), 0.25);
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.625);
  EXPECT_EQ(opacity(3, field::FieldKind::density), 1);
  EXPECT_EQ(opacity(3, field::FieldKind::level_set), 0.25);
  EXPECT_EQ(material_of(job, isos, 1, field::FieldKind::density)->colour, glm::dvec3(0));
  EXPECT_NEAR(material_of(job, isos, 2, field::FieldKind::density)->colour->x, 0.214, 0.003);
  job.opacity = {0.1, 0.2, 0.3};
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.3);
  job.colour.reset();
  job.opacity = {0.5};
  const auto plain = material_of(job, isos, 1, field::FieldKind::density);
  ASSERT_TRUE(plain);
  EXPECT_EQ(*plain, (mesh::Material{{}, 0.5}));
  isos = {1, 3, 2, 3};  // a value that was found can be one that was given: it has one surface
  job.opacity = {0.1, 0.2, 0.3, 0.4};
  EXPECT_EQ(opacity(3, field::FieldKind::density), 0.2);
  job.opacity.clear();
  job.colour = ColourChoice{{}, edit::Colormap::gray, {}};
  EXPECT_EQ(opacity(2, field::FieldKind::density), 0.625);
  EXPECT_EQ(opacity(3, field::FieldKind::density), 1);
  isos = {1};
  job.colour = ColourChoice{{}, edit::Colormap::gray, {}};
  EXPECT_EQ(opacity(1, field::FieldKind::density), 1);
}

TEST(AttributePlace, FilesAreToldFromGrids) {
  const auto place = [](std::string from, std::string name = "n") {
    const AttributePlace found = attribute_place({std::move(name), std::move(from), true});
    return found.file + "|" + found.grid.value_or("-");
  };
  EXPECT_EQ(place("temperature"), "|temperature");
  EXPECT_EQ(place("velocity[x]"), "|velocity[x]");
  EXPECT_EQ(place("nowhere/b.NII.GZ"), "nowhere/b.NII.GZ|-");
  EXPECT_EQ(place("b.vdb[velocity[x]]"), "b.vdb|velocity[x]");
  EXPECT_EQ(place("demo:sphere?size=8"), "demo:sphere?size=8|-");
  const test::TempFolder folder;
  const std::string file = (folder / "plain").string();
  EXPECT_EQ(place(file), "|" + file);
  std::ofstream(file) << "is there";
  EXPECT_EQ(place(file), file + "|-");
  EXPECT_EQ(place(file, file), "|" + file);  // the attribute's own name is a grid's
  EXPECT_EQ(place((folder / "").string()), (folder / "").string() + "|-");
}

}  // namespace
}  // namespace isoextract::convert

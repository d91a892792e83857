#include "edit/vertex_colors.hpp"

#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace isoextract::edit {
namespace {

constexpr auto kBytes = ColorStorage::srgb_u8;

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
std::vector<T> colors_of(const mesh::Mesh& mesh) {
  const mesh::Attribute& colors = mesh.attributes.back();
  std::vector<T> numbers(colors.values.size() / sizeof(T));
  if (!numbers.empty()) std::memcpy(numbers.data(), colors.values.data(), colors.values.size());
  return numbers;
}

TEST(VertexColors, StoresLinearForGltfAndSrgbForPly) {
  mesh::Mesh mesh = with_values({0, 1, 0.5});
  const auto record = color_by_values(mesh, "heat", Colormap::gray, {}, ColorStorage::linear_u16, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->range, (std::array{0.0, 1.0}));
  EXPECT_EQ(mesh.attributes.back().type, mesh::ComponentType::u16);
  EXPECT_TRUE(mesh.attributes.back().normalized);
  const auto linear = colors_of<std::uint16_t>(mesh);
  EXPECT_EQ((std::vector(linear.begin(), linear.begin() + 8)),
            (std::vector<std::uint16_t>{0, 0, 0, 65535, 65535, 65535, 65535, 65535}));
  EXPECT_NEAR(linear[8], 65535 * 0.2140, 150);  // the middle of sRGB

  mesh::Mesh other = with_values({0, 1, 0.5});
  ASSERT_TRUE(color_by_values(other, "heat", Colormap::gray, {}, kBytes, Context()));
  EXPECT_EQ(colors_of<std::uint8_t>(other), (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 128, 128, 128}));
}

TEST(VertexColors, HandlesRangesVectorsAndNan) {
  mesh::Mesh mesh = with_values({kNan, 5, 10, std::numeric_limits<float>::infinity()});
  auto record = color_by_values(mesh, "heat", Colormap::gray, std::array{0.0, 10.0}, kBytes, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->not_numbers, 1U);
  const auto gray = colors_of<std::uint8_t>(mesh);
  EXPECT_EQ((std::array{gray[0], gray[3], gray[6], gray[9]}), (std::array<std::uint8_t, 4>{128, 128, 255, 255}));

  mesh::Mesh vectors = with_values({3, 4, 0, 0, 0, 0, 0, -5, 12}, 3);
  record = color_by_values(vectors, "heat", Colormap::gray, {}, kBytes, Context());
  ASSERT_TRUE(record);
  EXPECT_EQ(record->range, (std::array{0.0, 13.0}));

  mesh::Mesh high = with_values({4, 8, 6});
  ASSERT_TRUE(color_by_values(high, "heat", Colormap::gray, {}, kBytes, Context()));
  EXPECT_EQ(colors_of<std::uint8_t>(high), (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 128, 128, 128}));
  mesh::Mesh given = with_values({4, 8, 1});
  ASSERT_TRUE(color_by_values(given, "heat", Colormap::gray, std::array{2.0, 6.0}, kBytes, Context()));
  EXPECT_EQ(colors_of<std::uint8_t>(given), (std::vector<std::uint8_t>{128, 128, 128, 255, 255, 255, 0, 0, 0}));

  mesh::Mesh alike = with_values({2, 2});
  ASSERT_TRUE(color_by_values(alike, "heat", Colormap::gray, {}, kBytes, Context()));
  EXPECT_EQ(colors_of<std::uint8_t>(alike).front(), 128);

  mesh::Mesh none = with_values({});
  ASSERT_TRUE(color_by_values(none, "heat", Colormap::gray, {}, kBytes, Context()));
  EXPECT_FALSE(color_by_values(mesh, "heat", Colormap::gray, {}, kBytes, Context{MemoryBudget(1)}));
}

TEST(VertexColors, ColorsAllVertices) {
  mesh::Mesh mesh = with_values({1, 2});
  ASSERT_TRUE(color_uniformly(mesh, {1, 0.5, 0}, Context()));
  EXPECT_EQ(colors_of<std::uint8_t>(mesh), (std::vector<std::uint8_t>{255, 128, 0, 255, 128, 0}));
}

}  // namespace
}  // namespace isoextract::edit

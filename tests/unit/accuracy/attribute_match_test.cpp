#include "accuracy/attribute_match.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "support/sample_attributes.hpp"

namespace isoextract::accuracy {
namespace {

mesh::Mesh three_vertices() {
  mesh::Mesh mesh;
  mesh.positions = Buffer<glm::vec3>(3);
  for (std::size_t v = 0; v < 3; ++v) mesh.positions[v] = glm::vec3(static_cast<float>(v), 0, 1);
  return mesh;
}

void set(mesh::Attribute& attribute, std::size_t value, float number) {
  std::memcpy(attribute.values.data() + value * sizeof number, &number, sizeof number);
}

TEST(AttributeMatch, MeasuresDifferencesOfCommonAttributes) {
  mesh::Mesh a = three_vertices();
  test::add_attribute(a, "heat", mesh::ComponentType::f32, 2);
  test::add_attribute(a, "mine", mesh::ComponentType::f32, 1);
  mesh::Mesh b = mesh::copy(a);
  b.attributes[1].name = "theirs";
  set(a.attributes[0], 3, 4);
  set(b.attributes[0], 3, 1);
  const AttributeMatches found = match_attributes(a, b, true);
  EXPECT_TRUE(found.same_vertices);
  EXPECT_EQ(found.only[0], std::vector<std::string>{"mine"});
  EXPECT_EQ(found.only[1], std::vector<std::string>{"theirs"});
  ASSERT_EQ(found.both.size(), 1U);
  ASSERT_TRUE(found.both[0].difference);
  EXPECT_EQ(found.both[0].difference->largest, 3);
  EXPECT_EQ(found.both[0].difference->vertex, 1U);
  EXPECT_EQ(found.both[0].difference->mean, 0.5);
}

TEST(AttributeMatch, CountsNonFiniteValues) {
  mesh::Mesh a = three_vertices();
  test::add_attribute(a, "heat", mesh::ComponentType::f32, 1);
  mesh::Mesh b = mesh::copy(a);
  set(a.attributes[0], 0, std::numeric_limits<float>::quiet_NaN());
  set(b.attributes[0], 0, std::numeric_limits<float>::quiet_NaN());
  set(a.attributes[0], 1, std::numeric_limits<float>::infinity());
  const auto difference = match_attributes(a, b, true).both.at(0).difference;
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->largest, 0);
  EXPECT_EQ(difference->not_finite, 1U);
}

TEST(AttributeMatch, MatchesColorsByRoleAsFractions) {
  mesh::Mesh a = three_vertices();
  mesh::Mesh b = three_vertices();
  test::add_attribute(a, "red", mesh::ComponentType::u8, 3, true, mesh::AttributeRole::color);
  test::add_attribute(b, "color", mesh::ComponentType::u16, 3, true, mesh::AttributeRole::color);
  std::memset(a.attributes[0].values.data(), 0xFF, a.attributes[0].values.size());
  std::memset(b.attributes[0].values.data(), 0xFF, b.attributes[0].values.size());
  const AttributeMatches same = match_attributes(a, b, true);
  ASSERT_EQ(same.both.size(), 1U);
  EXPECT_EQ(same.both[0].difference.value().largest, 0);
  EXPECT_FALSE(match_attributes(a, b, false).both.at(0).difference);
}

TEST(AttributeMatch, ComparesOnlyNamesIfVerticesDiffer) {
  mesh::Mesh a = three_vertices();
  test::add_attribute(a, "heat", mesh::ComponentType::f32, 1);
  mesh::Mesh b = mesh::copy(a);
  b.positions[2].x += 1;
  const AttributeMatches moved = match_attributes(a, b, true);
  EXPECT_FALSE(moved.same_vertices);
  ASSERT_EQ(moved.both.size(), 1U);
  EXPECT_FALSE(moved.both[0].difference);
}

TEST(AttributeMatch, AllowsPositionTolerance) {
  mesh::Mesh a = three_vertices();
  mesh::Mesh b = mesh::copy(a);
  b.positions[2].x += 0.25F;
  EXPECT_TRUE(match_attributes(a, b, true, 0.25).same_vertices);
  EXPECT_FALSE(match_attributes(a, b, true, 0.2).same_vertices);
  b.positions[2].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(match_attributes(a, b, true, 0.25).same_vertices);
}

TEST(AttributeMatch, DerivesRoundingFromStoredCoordinates) {
  constexpr double kEpsilon = std::numeric_limits<float>::epsilon();
  mesh::Mesh mesh = three_vertices();
  mesh.positions[1] = {0.5F, -3, 0};
  mesh.origin = {0, 0, 1024};                             // every place is a float32 number
  EXPECT_EQ(coordinate_rounding(mesh), 1025 * kEpsilon);  // from the vertices at z = 1
  mesh.origin.z += 0x1p-40;
  EXPECT_EQ(coordinate_rounding(mesh), 3 * kEpsilon);
}

}  // namespace
}  // namespace isoextract::accuracy

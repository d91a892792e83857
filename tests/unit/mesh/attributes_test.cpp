#include "mesh/attributes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

#include "mesh/split_vertices.hpp"
#include "support/sample_attributes.hpp"
#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

Mesh mesh_with_everything() {
  Mesh mesh = test::unit_tetrahedron();
  mesh.normals = Buffer<glm::vec3>(4);
  mesh.edges = Buffer<EdgeKey>(4);
  for (std::size_t v = 0; v < 4; ++v) {
    mesh.normals[v] = glm::vec3(static_cast<float>(v));
    mesh.edges[v] = {glm::ivec3(static_cast<std::int32_t>(v)), 1};
  }
  test::add_color(mesh, ComponentType::u8, 3);
  test::add_attribute(mesh, "heat", ComponentType::f64, 1);
  return mesh;
}

// Returns whether vertex v of `mesh` has the same data as vertex w of `other`.
bool same_vertex(const Mesh& mesh, std::size_t v, const Mesh& other, std::size_t w) {
  bool same = mesh.positions[v] == other.positions[w] && mesh.normals[v] == other.normals[w] &&
              mesh.edges[v] == other.edges[w] && mesh.attributes.size() == other.attributes.size();
  for (std::size_t a = 0; same && a < mesh.attributes.size(); ++a) {
    same = std::ranges::equal(mesh.attributes[a].at(v), other.attributes[a].at(w));
  }
  return same;
}

TEST(Attributes, GatherCopiesAllVertexData) {
  const Mesh before = mesh_with_everything();
  EXPECT_EQ(vertex_bytes(before), 2 * sizeof(glm::vec3) + sizeof(EdgeKey) + 3 + 8);
  Mesh mesh = copy(before);
  constexpr std::array<std::uint32_t, 5> kOld{3, 0, 0, 2, 3};
  gather_vertices(mesh, kOld);
  ASSERT_EQ(mesh.positions.size(), kOld.size());
  for (std::size_t v = 0; v < kOld.size(); ++v) EXPECT_TRUE(same_vertex(mesh, v, before, kOld[v])) << v;
  gather_vertices(mesh, {});
  EXPECT_TRUE(mesh.positions.empty() && mesh.attributes[0].values.empty());
}

TEST(Attributes, SplitFansCopyAttributes) {
  Mesh mesh = mesh_with_everything();
  constexpr std::array<glm::uvec3, 2> kTwoFans{{{0, 1, 2}, {3, 0, 3}}};
  mesh.triangles = Buffer<glm::uvec3>(2);
  std::ranges::copy(kTwoFans, mesh.triangles.begin());
  const Mesh before = copy(mesh);
  ASSERT_TRUE(split_nonmanifold_vertices(mesh, "test", Context()));
  for (std::size_t t = 0; t < 2; ++t) {
    for (int corner = 0; corner < 3; ++corner) {
      EXPECT_TRUE(same_vertex(mesh, mesh.triangles[t][corner], before, before.triangles[t][corner]));
    }
  }
  EXPECT_NE(mesh.triangles[0].x, mesh.triangles[1].y);
}

// Returns the value at fraction `t` between two values.
template <class T>
T between(const Attribute& form, T from, T to, double t) {
  Attribute attribute = form.without_values();
  attribute.values = Buffer<std::byte>(3 * sizeof(T));
  std::memcpy(attribute.values.data(), &from, sizeof(T));
  std::memcpy(attribute.values.data() + sizeof(T), &to, sizeof(T));
  set_interpolated(attribute, 2, attribute, {0, 1, t});
  T value;
  std::memcpy(&value, attribute.values.data() + 2 * sizeof(T), sizeof(T));
  return value;
}

TEST(Attributes, InterpolatesByType) {
  const Attribute heat{"heat", AttributeRole::other, ComponentType::f32, 1, false, {}};
  EXPECT_EQ(between(heat, 1.0F, 3.0F, 0.25), 1.5F);
  const float infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(between(heat, infinite, infinite, 0.25), infinite);
  EXPECT_EQ(between(heat, 0.1F, 0.1F, 0.3), 0.1F);
  const Attribute wide{"wide", AttributeRole::other, ComponentType::f64, 1, false, {}};
  EXPECT_EQ(between(wide, -1.5e308, 1.5e308, 0.5), 0);
  const Attribute color{"color", AttributeRole::color, ComponentType::u8, 1, true, {}};
  EXPECT_EQ(between<std::uint8_t>(color, 255, 0, 0.25), 191);
  EXPECT_EQ(between<std::uint8_t>(color, 0, 255, 0), 0);
  EXPECT_EQ(between<std::uint8_t>(color, 0, 255, 1), 255);
  const Attribute share{"share", AttributeRole::other, ComponentType::i16, 1, true, {}};
  EXPECT_EQ(between<std::int16_t>(share, -30000, 30000, 0.25), -15000);
  // Integers that are not normalized may be labels.
  const Attribute label{"label", AttributeRole::other, ComponentType::i32, 1, false, {}};
  EXPECT_EQ(between(label, 2, 9, 0.25), 2);
  EXPECT_EQ(between(label, 2, 9, 0.5), 2);
  EXPECT_EQ(between(label, 2, 9, 0.75), 9);
}

TEST(Attributes, InterpolatesNormalsToUnitLength) {
  Buffer<glm::vec3> normals(3);
  normals[0] = {1, 0, 0};
  normals[1] = {0, 1, 0};
  normals[2] = {-1, 0, 0};
  EXPECT_EQ(interpolated_normal(normals, {0, 1, 0}), normals[0]);
  EXPECT_EQ(interpolated_normal(normals, {0, 1, 1}), normals[1]);
  EXPECT_LT(glm::length(interpolated_normal(normals, {0, 1, 0.5}) - glm::vec3(std::sqrt(0.5F), std::sqrt(0.5F), 0)),
            1e-6F);
  EXPECT_EQ(interpolated_normal(normals, {2, 0, 0.5}), normals[2]) << "they cancel out";
}

TEST(Attributes, CopyIsComplete) {
  const Mesh mesh = mesh_with_everything();
  const Mesh same = copy(mesh);
  ASSERT_EQ(same.positions.size(), mesh.positions.size());
  for (std::size_t v = 0; v < 4; ++v) EXPECT_TRUE(same_vertex(same, v, mesh, v));
  EXPECT_TRUE(std::ranges::equal(same.triangles, mesh.triangles));
  for (std::size_t a = 0; a < 2; ++a) EXPECT_TRUE(test::same_attribute(same.attributes[a], mesh.attributes[a]));
}

}  // namespace
}  // namespace isoextract::mesh

#include "mesh/attribute_map.hpp"

#include <algorithm>
#include <cstring>

#include <gtest/gtest.h>

#include "mesh/mesh.hpp"
#include "support/sample_attributes.hpp"
#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

Mesh mesh_with_vectors(ComponentType type) {
  Mesh mesh = test::unit_tetrahedron();
  test::add_attribute(mesh, "a", type, 3);
  return mesh;
}

// A right-angle rotation around z, a stretch, a mirror, and a translation.
const glm::dmat3 kLinear{{0, 2, 0}, {-3, 0, 0}, {0, 0, -1}};
const glm::dvec3 kOffset{10, 20, 30};

TEST(AttributeMap, TransformsByKind) {
  const Mesh before = mesh_with_vectors(ComponentType::f64);
  for (const AttributeKind kind : {AttributeKind::scalar, AttributeKind::color, AttributeKind::vector,
                                   AttributeKind::point, AttributeKind::normal}) {
    Mesh mesh = mesh_with_vectors(ComponentType::f64);
    map_attribute(mesh.attributes.front(), kind, kLinear, kOffset);
    for (std::size_t v = 0; v < 4; ++v) {
      glm::dvec3 old;
      glm::dvec3 found;
      std::memcpy(&old, before.attributes.front().at(v).data(), sizeof old);
      std::memcpy(&found, mesh.attributes.front().at(v).data(), sizeof found);
      glm::dvec3 wanted = old;
      if (kind == AttributeKind::vector) wanted = {-3 * old.y, 2 * old.x, -old.z};
      if (kind == AttributeKind::point) wanted = glm::dvec3(-3 * old.y, 2 * old.x, -old.z) + kOffset;
      if (kind == AttributeKind::normal) wanted = glm::normalize(glm::dvec3(-old.y / 3, old.x / 2, -old.z));
      EXPECT_LT(glm::length(found - wanted), 1e-15 * glm::length(wanted)) << word_of(kind);
    }
  }
}

TEST(AttributeMap, MappedIntegersBecomeFloats) {
  Mesh mesh = mesh_with_vectors(ComponentType::i16);
  const std::int16_t before[3] = {1, -2, 3};
  std::memcpy(mesh.attributes.front().values.data(), before, sizeof before);
  map_attribute(mesh.attributes.front(), AttributeKind::vector, kLinear, kOffset);
  EXPECT_EQ(mesh.attributes.front().type, ComponentType::f32);
  glm::vec3 found;
  std::memcpy(&found, mesh.attributes.front().at(0).data(), sizeof found);
  EXPECT_EQ(found, glm::vec3(6, 2, -3));
}

TEST(AttributeMap, KeepsColorsAndOtherComponentCounts) {
  Mesh mesh = test::unit_tetrahedron();
  test::add_color(mesh, ComponentType::f32, 3);
  test::add_attribute(mesh, "pair", ComponentType::f32, 2);
  const Mesh before = copy(mesh);
  for (std::size_t a = 0; a < 2; ++a) {
    map_attribute(mesh.attributes[a], AttributeKind::vector, kLinear, kOffset);
    EXPECT_TRUE(test::same_attribute(mesh.attributes[a], before.attributes[a]));
  }
}

TEST(AttributeMap, ZeroNormalStaysZero) {
  Mesh mesh = mesh_with_vectors(ComponentType::f32);
  std::ranges::fill(mesh.attributes.front().values, std::byte{0});
  map_attribute(mesh.attributes.front(), AttributeKind::normal, kLinear, kOffset);
  EXPECT_TRUE(
      std::ranges::all_of(mesh.attributes.front().values.span(), [](std::byte b) { return b == std::byte{0}; }));
}

}  // namespace
}  // namespace isoextract::mesh

#include "convert/attribute_source.hpp"

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/fields.hpp"
#include "unit/mesh/shapes.hpp"

namespace isoextract::convert {
namespace {

// Returns a grid of vectors (1, 2, 3) with voxels of 2 x 4 x 8 world units.
AttributeSource source_of_vectors(AttributeKind kind, bool in_voxels) {
  VolumeAttribute attribute;
  attribute.choice.name = "a";
  attribute.choice.from = "a";
  attribute.stated_kind = kind;
  attribute.in_voxels = in_voxels;
  for (const float value : {1.0F, 2.0F, 3.0F}) {
    attribute.components.push_back(test::dense_field<float>(glm::ivec3(3), [&](int, int, int) { return value; }));
    attribute.components.back().index_to_world = field::scaling({2, 4, 8});
  }
  AttributeSource source;
  source.from = std::vector<VolumeAttribute>{std::move(attribute)};
  return source;
}

glm::vec3 first_value(const mesh::Mesh& mesh) {
  glm::vec3 value;
  std::memcpy(&value, mesh.attributes.front().at(0).data(), sizeof value);
  return value;
}

TEST(AttributeSource, TransformsVectorsFromIndexToOutputSpace) {
  struct Case {
    AttributeKind kind;
    bool in_voxels;
    glm::vec3 wanted;
  };
  // The mesh is the world scaled by 10 and moved by 1 along each axis.
  for (const auto& [kind, in_voxels, wanted] :
       {Case{AttributeKind::vector, false, {10, 20, 30}}, Case{AttributeKind::vector, true, {20, 80, 240}},
        Case{AttributeKind::point, true, {21, 81, 241}}, Case{AttributeKind::scalar, true, {1, 2, 3}},
        Case{AttributeKind::normal, true, glm::normalize(glm::vec3(0.5F, 0.5F, 0.375F))}}) {
    AttributeSource source = source_of_vectors(kind, in_voxels);
    const field::Affine output_from_world{field::scaling(glm::dvec3(10)).linear, glm::dvec3(1)};
    ASSERT_TRUE(set_attribute_maps(source, output_from_world.inverse(), output_from_world));
    mesh::Mesh mesh = test::unit_tetrahedron();
    const auto records = add_attributes(source, mesh, Context());
    ASSERT_TRUE(records);
    EXPECT_EQ(records->front().kind, kind);
    EXPECT_EQ(records->front().changed, is_transformed_with_mesh(kind));
    transform_attributes(mesh, source.kinds, source.output_from_world);
    EXPECT_LT(glm::length(first_value(mesh) - wanted), 1e-6F * glm::length(wanted)) << word_of(kind) << in_voxels;
  }
}

TEST(AttributeSource, TranslatesOnlyPoints) {
  for (const AttributeKind kind : {AttributeKind::vector, AttributeKind::normal, AttributeKind::point}) {
    AttributeSource source = source_of_vectors(kind, false);
    const field::Affine moved{glm::dmat3(1), {1, 2, 3}};
    ASSERT_TRUE(set_attribute_maps(source, moved.inverse(), moved));
    mesh::Mesh mesh = test::unit_tetrahedron();
    const auto records = add_attributes(source, mesh, Context());
    ASSERT_TRUE(records);
    EXPECT_EQ(records->front().changed, kind == AttributeKind::point) << word_of(kind);
  }
}

TEST(AttributeSource, FindsKindByNameStatementAndChoice) {
  const auto kind = [](std::string name, std::string from, std::size_t components,
                       std::optional<AttributeKind> stated = {}, std::optional<AttributeKind> chosen = {}) {
    AttributeChoice choice;
    choice.name = std::move(name);
    choice.from = std::move(from);
    choice.kind = chosen;
    return find_kind(choice, components, stated).value();
  };
  EXPECT_EQ(kind("v", "v", 3), AttributeKind::vector);
  EXPECT_EQ(kind("x", "fire.vdb[velocity]", 3), AttributeKind::vector);
  EXPECT_EQ(kind("x", "y", 3), std::nullopt);
  EXPECT_EQ(kind("v", "v", 1), AttributeKind::scalar);
  EXPECT_EQ(kind("v", "v", 4), AttributeKind::scalar);
  EXPECT_EQ(kind("Cd", "Cd", 4), AttributeKind::color);
  EXPECT_EQ(kind("v", "v", 3, AttributeKind::normal), AttributeKind::normal);
  EXPECT_EQ(kind("v", "v", 3, AttributeKind::normal, AttributeKind::scalar), AttributeKind::scalar);
}

}  // namespace
}  // namespace isoextract::convert

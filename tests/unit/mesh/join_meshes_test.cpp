#include "mesh/join_meshes.hpp"

#include <array>

#include <gtest/gtest.h>

#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

TEST(Joined, ConcatenatesMeshes) {
  std::array<Mesh, 3> meshes{test::unit_tetrahedron(), Mesh{}, test::unit_tetrahedron()};
  for (Mesh& mesh : meshes) {
    if (!mesh.positions.empty()) mesh.origin = {1, 2, 3};
  }
  meshes[2].positions[3] = {0, 0, 9};
  const Context context;
  {
    const auto joined = join_meshes(meshes, context);
    ASSERT_TRUE(joined) << joined.error().message;
    EXPECT_EQ(joined->origin, glm::dvec3(1, 2, 3));
    ASSERT_EQ(joined->positions.size(), 8U);
    ASSERT_EQ(joined->triangles.size(), 8U);
    EXPECT_EQ(joined->positions[3], glm::vec3(0, 0, 1));
    EXPECT_EQ(joined->positions[7], glm::vec3(0, 0, 9));
    EXPECT_EQ(joined->triangles[3], glm::uvec3(1, 2, 3));
    EXPECT_EQ(joined->triangles[7], glm::uvec3(5, 6, 7));
    EXPECT_EQ(context.memory().reserved(), 8 * (sizeof(glm::vec3) + sizeof(glm::uvec3)));
  }
  EXPECT_FALSE(join_meshes(meshes, Context(MemoryBudget(100))));
  const auto none = join_meshes({}, context);
  ASSERT_TRUE(none);
  EXPECT_TRUE(none->positions.empty());
}

}  // namespace
}  // namespace isoextract::mesh

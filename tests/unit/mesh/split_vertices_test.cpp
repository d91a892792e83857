#include "mesh/split_vertices.hpp"

#include <gtest/gtest.h>

#include "mesh/adjacency.hpp"
#include "mesh/topology.hpp"
#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

using test::make_mesh;

TEST(VertexFans, SplitsFansAndRemovesUnusedVertices) {
  // Two triangles that share only vertex 2, and the unused vertices 0 and 4.
  Mesh mesh =
      make_mesh({{9, 9, 9}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}, {9, 9, 9}, {5, 0, 0}, {6, 0, 0}}, {{1, 2, 3}, {2, 5, 6}});
  mesh.normals = Buffer<glm::vec3>(7);
  std::copy(mesh.positions.begin(), mesh.positions.end(), mesh.normals.begin());
  mesh.edges = Buffer<EdgeKey>(7);
  std::ranges::transform(mesh.positions, mesh.edges.begin(), [](const glm::vec3& p) {
    return EdgeKey{glm::ivec3(p), 4};
  });
  ASSERT_TRUE(split_nonmanifold_vertices(mesh, "test", Context()));
  ASSERT_EQ(mesh.positions.size(), 6U);
  EXPECT_EQ(mesh.triangles[0], glm::uvec3(0, 1, 3));
  EXPECT_EQ(mesh.triangles[1], glm::uvec3(2, 4, 5));
  ASSERT_EQ(mesh.edges.size(), 6U);
  for (std::size_t v = 0; v < 6; ++v) {
    EXPECT_EQ(mesh.normals[v], mesh.positions[v]);
    EXPECT_EQ(mesh.edges[v], (EdgeKey{glm::ivec3(mesh.positions[v]), 4}));
  }
  EXPECT_EQ(mesh.positions[1], mesh.positions[2]);
  const Topology topology = measure_topology(mesh);
  EXPECT_EQ(topology.nonmanifold_vertices + topology.unused_vertices, 0U);
  EXPECT_EQ(topology.components, 2U);
}

TEST(VertexFans, KeepsManifoldUnchanged) {
  const Mesh before = test::unit_tetrahedron();
  Mesh mesh = test::unit_tetrahedron();
  ASSERT_TRUE(split_nonmanifold_vertices(mesh, "test", Context()));
  EXPECT_TRUE(std::ranges::equal(mesh.positions, before.positions));
  EXPECT_TRUE(std::ranges::equal(mesh.triangles, before.triangles));
}

TEST(VertexFans, KeepsToMemoryLimit) {
  Mesh mesh = test::unit_tetrahedron();
  const auto done = split_nonmanifold_vertices(mesh, "a.raw", Context(MemoryBudget(100)));
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("a.raw"), std::string::npos);
}

// A Latin square: any two of the triangles share at most one vertex, so each of the vertices has many fans.
TEST(VertexFans, ReservesMemoryForAllFans) {
  constexpr std::uint32_t kSide = 40;
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t i = 0; i < kSide; ++i) {
    for (std::uint32_t j = 0; j < kSide; ++j) triangles.emplace_back(i, kSide + j, 2 * kSide + (i + j) % kSide);
  }
  Mesh mesh = make_mesh(std::vector<glm::vec3>(3 * kSide), triangles);
  const std::uint64_t corners = 3 * triangles.size();
  const std::uint64_t others = Adjacency::bytes(triangles.size(), 3 * kSide) + triangles.size() * sizeof(glm::uvec3);
  const Context context(MemoryBudget(std::uint64_t{1} << 30));
  ASSERT_TRUE(split_nonmanifold_vertices(mesh, "test", context));
  EXPECT_EQ(mesh.positions.size(), corners);
  EXPECT_GE(context.memory().peak(), others + corners * (sizeof(glm::vec3) + sizeof(std::uint32_t)));

  Mesh again = make_mesh(std::vector<glm::vec3>(3 * kSide), triangles);
  const auto done = split_nonmanifold_vertices(again, "a.raw", Context(MemoryBudget(context.memory().peak() - 1)));
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(again.positions.size(), 3 * kSide) << "the mesh stays as it was";
}

}  // namespace
}  // namespace isoextract::mesh

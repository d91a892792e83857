#include "mesh/topology.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

using test::make_mesh;

TEST(Topology, RecognizesTetrahedronAsSphere) {
  const Topology t = measure_topology(test::unit_tetrahedron());
  EXPECT_TRUE(t.is_closed_oriented_manifold());
  EXPECT_EQ(t.edges, 6U);
  EXPECT_EQ(t.components, 1U);
  EXPECT_EQ(t.euler, 2);
  EXPECT_EQ(t.genus(), 0);
}

TEST(Topology, RecognizesSevenVertexTorus) {
  // Moebius and Csaszar: every two of the seven vertices share an edge.
  std::vector<glm::uvec3> triangles;
  for (unsigned i = 0; i < 7; ++i) {
    triangles.push_back({i, (i + 1) % 7, (i + 3) % 7});
    triangles.push_back({i, (i + 3) % 7, (i + 2) % 7});
  }
  const Topology t = measure_topology(make_mesh(std::vector<glm::vec3>(7), triangles));
  EXPECT_TRUE(t.is_closed_oriented_manifold());
  EXPECT_EQ(t.euler, 0);
  EXPECT_EQ(t.genus(), 1);
}

TEST(Topology, CountsOpenEdges) {
  const Topology t = measure_topology(make_mesh(std::vector<glm::vec3>(4), {{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(t.open_edges, 4U);
  EXPECT_EQ(t.edges, 5U);
  EXPECT_EQ(t.nonmanifold_vertices, 0U);
}

TEST(Topology, CountsMisorientedEdges) {
  EXPECT_EQ(measure_topology(make_mesh(std::vector<glm::vec3>(4), {{0, 1, 2}, {0, 2, 3}})).misoriented_edges, 0U);
  EXPECT_EQ(measure_topology(make_mesh(std::vector<glm::vec3>(4), {{0, 1, 2}, {2, 0, 3}})).misoriented_edges, 1U);
}

TEST(Topology, CountsNonmanifoldEdges) {
  const Topology t = measure_topology(make_mesh(std::vector<glm::vec3>(5), {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}}));
  EXPECT_EQ(t.nonmanifold_edges, 1U);
}

TEST(Topology, CountsNonmanifoldVertices) {
  // Two tetrahedra that share only vertex 0.
  const Topology t = measure_topology(
      make_mesh(std::vector<glm::vec3>(7),
                {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}, {0, 5, 4}, {0, 4, 6}, {0, 6, 5}, {4, 5, 6}}));
  EXPECT_EQ(t.nonmanifold_vertices, 1U);
  EXPECT_EQ(t.nonmanifold_edges, 0U);
  EXPECT_EQ(t.components, 1U);
}

TEST(Topology, CountsRepeatedIndicesAndUnusedVertices) {
  const Topology t = measure_topology(make_mesh(std::vector<glm::vec3>(5), {{0, 1, 2}, {2, 2, 1}}));
  EXPECT_EQ(t.repeated_index_triangles, 1U);
  EXPECT_EQ(t.unused_vertices, 2U);
}

// Counts edge by edge with a map.
Topology edges_by_plain_loops(const std::vector<glm::uvec3>& triangles, std::uint32_t vertices) {
  Topology facts;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<bool>> edges;
  std::set<std::uint32_t> used;
  for (const glm::uvec3& t : triangles) {
    if (t.x == t.y || t.y == t.z || t.z == t.x) {
      ++facts.repeated_index_triangles;
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t a = t[c];
      const std::uint32_t b = t[(c + 1) % 3];
      edges[std::minmax(a, b)].push_back(a < b);
      used.insert(a);
    }
  }
  for (const auto& [ends, uses] : edges) {
    ++facts.edges;
    facts.open_edges += uses.size() == 1 ? 1 : 0;
    facts.nonmanifold_edges += uses.size() > 2 ? 1 : 0;
    facts.misoriented_edges += uses.size() == 2 && uses[0] == uses[1] ? 1 : 0;
  }
  facts.unused_vertices = vertices - used.size();
  return facts;
}

TEST(Topology, EqualsPlainLoopForAnyThreads) {
  constexpr std::uint32_t kVertices = 5000;
  for (const std::size_t triangles : {1500U, 6000U}) {
    const auto random = test::random_triangles(triangles, kVertices, 3);
    const Topology expected = edges_by_plain_loops(random, kVertices);
    ASSERT_GT(expected.misoriented_edges, 0U);
    ASSERT_GT(expected.nonmanifold_edges, 0U);
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const Topology found = measure_topology(make_mesh(std::vector<glm::vec3>(kVertices), random));
      EXPECT_EQ(found.edges, expected.edges);
      EXPECT_EQ(found.open_edges, expected.open_edges);
      EXPECT_EQ(found.nonmanifold_edges, expected.nonmanifold_edges);
      EXPECT_EQ(found.misoriented_edges, expected.misoriented_edges);
      EXPECT_EQ(found.repeated_index_triangles, expected.repeated_index_triangles);
      EXPECT_EQ(found.unused_vertices, expected.unused_vertices);
    }
  }
}

// A square of `side` x `side` vertices, numbered along the rows or, if not `near`, scattered.
Mesh square(std::uint32_t side, bool near) {
  const std::uint32_t vertices = side * side;
  const auto name = [&](std::uint32_t v) {
    constexpr std::uint64_t kPrime = 1'000'003;
    return near ? v : static_cast<std::uint32_t>(v * kPrime % vertices);
  };
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t v = y * side + x;
      triangles.push_back({name(v), name(v + 1), name(v + side + 1)});
      triangles.push_back({name(v), name(v + side + 1), name(v + side)});
    }
  }
  return make_mesh(std::vector<glm::vec3>(vertices), triangles);
}

TEST(Topology, NeedsLessMemoryThanLargeMesh) {
  constexpr std::uint32_t kSide = 700;
  for (const bool near : {true, false}) {
    const Mesh mesh = square(kSide, near);
    const Context context;
    const auto t = measure_topology(mesh, context);
    ASSERT_TRUE(t);
    EXPECT_EQ(t->open_edges, 4U * (kSide - 1));
    EXPECT_EQ(t->edges, 2U * kSide * (kSide - 1) + (kSide - 1) * (kSide - 1));
    EXPECT_EQ(t->euler, 1);
    EXPECT_EQ(t->components, 1U);
    EXPECT_EQ(t->nonmanifold_edges + t->misoriented_edges + t->nonmanifold_vertices, 0U);
    EXPECT_LT(context.memory().peak(), 3 * (mesh.positions.size_bytes() + mesh.triangles.size_bytes()) / 4);
  }
}

TEST(Topology, ReservesItsMemory) {
  const Mesh mesh = test::unit_tetrahedron();
  const Context context;
  const auto measured = measure_topology(mesh, context);
  ASSERT_TRUE(measured);
  EXPECT_EQ(measured->edges, 6U);
  EXPECT_EQ(context.memory().reserved(), 0U);
  EXPECT_GE(context.memory().peak(), 12 * sizeof(std::uint64_t));
  EXPECT_FALSE(measure_topology(mesh, Context(MemoryBudget(100))));
}

TEST(Topology, EmptyMeshIsNotClosed) {
  const Topology t = measure_topology(Mesh{});
  EXPECT_EQ(t.components, 0U);
  EXPECT_FALSE(t.is_closed_oriented_manifold());
}

}  // namespace
}  // namespace isoextract::mesh

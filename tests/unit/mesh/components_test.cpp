#include "mesh/components.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

using Triangles = std::vector<glm::uvec3>;

struct Labels {
  std::vector<std::uint32_t> of_vertex;
  std::uint32_t count = 0;
};

Labels found(const Triangles& triangles, std::size_t vertices) {
  const Components components(triangles, vertices);
  Labels labels{{}, components.count()};
  for (std::size_t v = 0; v < vertices; ++v) labels.of_vertex.push_back(components.of_vertex(v));
  return labels;
}

// Textbook disjoint sets on one thread.
Labels expected(const Triangles& triangles, std::size_t vertices) {
  std::vector<std::uint32_t> parent(vertices);
  std::iota(parent.begin(), parent.end(), 0U);
  std::vector<char> used(vertices, 0);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const glm::uvec3& t : triangles) {
    if (t.x == t.y || t.y == t.z || t.z == t.x) continue;
    used[t.x] = used[t.y] = used[t.z] = 1;
    parent[root(t.x)] = root(t.y);
    parent[root(t.y)] = root(t.z);
  }
  Labels labels{std::vector<std::uint32_t>(vertices, Components::kNone), 0};
  std::vector<std::uint32_t> number(vertices, Components::kNone);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    if (used[v] == 0) continue;
    std::uint32_t& n = number[root(v)];
    if (n == Components::kNone) n = labels.count++;
    labels.of_vertex[v] = n;
  }
  return labels;
}

void expect_same(const Triangles& triangles, std::size_t vertices) {
  const Labels is = found(triangles, vertices);
  const Labels should_be = expected(triangles, vertices);
  EXPECT_EQ(is.count, should_be.count);
  EXPECT_EQ(is.of_vertex, should_be.of_vertex);
}

TEST(Components, EqualTextbookAlgorithm) {
  expect_same({}, 0);
  expect_same({}, 4);
  std::uint32_t most = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Triangles triangles = test::random_triangles(20 + seed, 100, seed);
    expect_same(triangles, 100);
    most = std::max(most, expected(triangles, 100).count);
  }
  EXPECT_GE(most, 4U);
}

TEST(Components, RepeatedIndexDoesNotConnect) {
  const Components components(Triangles{{3, 4, 5}, {0, 1, 2}, {2, 2, 3}, {6, 6, 6}}, 7);
  EXPECT_EQ(components.count(), 2U);
  EXPECT_EQ(components.of_vertex(2), 0U);
  EXPECT_EQ(components.of_vertex(3), 1U);
  EXPECT_EQ(components.of_vertex(6), Components::kNone);
}

// Strips through the vertices in steps, so that threads join the same components at once. They also run from the last
// vertex down, which makes the longest paths to the roots.
TEST(Components, DoNotDependOnThreads) {
  constexpr std::uint32_t kVertices = 60000;
  for (const std::uint32_t step : {1U, 7U, 20000U}) {
    Triangles triangles;
    for (std::uint32_t v = 0; v + 2 * step < kVertices; ++v) {
      if (v / step % 5000 < 4998) triangles.emplace_back(v, v + step, v + 2 * step);
    }
    std::reverse(triangles.begin(), triangles.end());
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      expect_same(triangles, kVertices);
    }
  }
}

}  // namespace
}  // namespace isoextract::mesh

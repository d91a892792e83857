#include "mesh/adjacency.hpp"

#include <algorithm>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "unit/mesh/shapes.hpp"

namespace isoextract::mesh {
namespace {

using Triangles = std::vector<glm::uvec3>;

std::vector<std::vector<Corner>> corners_by_a_plain_loop(const Triangles& triangles, std::size_t vertices) {
  std::vector<std::vector<Corner>> corners(vertices);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) corners[triangles[t][c]].push_back(3 * t + static_cast<Corner>(c));
  }
  return corners;
}

void expect_rows(const Triangles& triangles, std::uint32_t vertices) {
  const auto expected = corners_by_a_plain_loop(triangles, vertices);
  const Adjacency adjacency(triangles, vertices);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    ASSERT_TRUE(std::ranges::equal(adjacency.corners(v), expected[v])) << "vertex " << v;
  }
}

TEST(Adjacency, RowsEqualPlainLoop) {
  expect_rows({}, 3);
  expect_rows({{2, 0, 1}}, 5);
  for (unsigned seed = 0; seed < 20; ++seed) expect_rows(test::random_triangles(60, 40, seed), 40);
}

// Several threads work on one row: many triangles use vertex 0.
TEST(Adjacency, RowsDoNotDependOnThreads) {
  constexpr std::uint32_t kVertices = 9000;
  Triangles triangles = test::random_triangles(20000, kVertices, 1);
  for (std::size_t t = 0; t < triangles.size(); t += 2) triangles[t].y = 0;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    expect_rows(triangles, kVertices);
  }
}

std::set<std::uint32_t> others(const Triangles& triangles, Corner corner) {
  const glm::uvec3& t = triangles[triangle_of(corner)];
  const auto c = static_cast<int>(corner % 3);
  return {t[(c + 1) % 3], t[(c + 2) % 3]};
}

// Puts corners with a common vertex into one fan until nothing changes.
std::vector<std::uint32_t> fans_by_plain_loops(const Triangles& triangles, const std::vector<Corner>& corners) {
  std::vector<std::size_t> first(corners.size());
  for (std::size_t i = 0; i < first.size(); ++i) first[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      for (std::size_t j = 0; j < corners.size(); ++j) {
        const auto a = others(triangles, corners[i]);
        const auto b = others(triangles, corners[j]);
        const bool meet = std::ranges::any_of(a, [&](std::uint32_t v) { return b.contains(v); });
        if (!meet || first[i] <= first[j]) continue;
        first[i] = first[j];
        changed = true;
      }
    }
  }
  std::vector<std::uint32_t> number;
  std::map<std::size_t, std::uint32_t> fans;
  for (const std::size_t f : first) {
    number.push_back(fans.try_emplace(f, static_cast<std::uint32_t>(fans.size())).first->second);
  }
  return number;
}

TEST(VertexStar, FansEqualPlainLoops) {
  constexpr std::uint32_t kVertices = 40;
  std::uint32_t most = 0;
  VertexStar star;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Triangles triangles = test::random_triangles(90, kVertices, seed);
    const auto corners = corners_by_a_plain_loop(triangles, kVertices);
    for (std::uint32_t v = 0; v < kVertices; ++v) {
      star.look_at(corners[v], triangles);
      const auto expected = fans_by_plain_loops(triangles, corners[v]);
      ASSERT_TRUE(std::ranges::equal(star.fan_of(), expected)) << "vertex " << v << ", seed " << seed;
      ASSERT_EQ(star.fans(), expected.empty() ? 0 : *std::ranges::max_element(expected) + 1);
      most = std::max(most, star.fans());
    }
  }
  EXPECT_GE(most, 3U);
}

TEST(VertexStar, SidesAreEdgesWithTheirTriangles) {
  // Around vertex 4: an edge to 1 with two triangles, and edges to 0, 2 and 3.
  const Triangles triangles{{4, 0, 1}, {1, 2, 4}, {0, 1, 2}, {3, 4, 2}};
  VertexStar star;
  star.look_at(Adjacency(triangles, 5).corners(4), triangles);
  const auto sides = star.sides();
  ASSERT_EQ(sides.size(), 6U);
  const std::vector<std::array<unsigned, 3>> expected{{0, 0, 1}, {1, 0, 0}, {1, 1, 1}, {2, 1, 0}, {2, 2, 1}, {3, 2, 0}};
  for (std::size_t s = 0; s < sides.size(); ++s) {
    EXPECT_EQ((std::array<unsigned, 3>{sides[s].end, sides[s].corner, sides[s].outgoing ? 1U : 0U}), expected[s]) << s;
  }
  EXPECT_EQ(star.fans(), 1U);
  EXPECT_FALSE(star.is_closed_fan());
}

bool is_closed_fan(const Triangles& triangles, std::uint32_t vertex) {
  VertexStar star;
  star.look_at(Adjacency(triangles, 9).corners(vertex), triangles);
  return star.is_closed_fan();
}

TEST(VertexStar, RecognizesClosedFan) {
  const Triangles ring{{0, 1, 2}, {2, 3, 0}, {3, 1, 0}};
  EXPECT_TRUE(is_closed_fan(ring, 0));
  EXPECT_FALSE(is_closed_fan(ring, 1));  // on the boundary
  EXPECT_FALSE(is_closed_fan(ring, 8));  // unused
  EXPECT_FALSE(is_closed_fan({{0, 1, 2}, {0, 3, 2}, {3, 1, 0}}, 0)) << "one winds against the others";
  EXPECT_FALSE(is_closed_fan({{0, 1, 2}, {0, 2, 1}, {0, 1, 2}, {0, 2, 1}}, 0)) << "each edge has four";
  EXPECT_FALSE(is_closed_fan({{0, 1, 2}, {2, 3, 0}, {3, 1, 0}, {0, 4, 5}, {0, 5, 6}, {0, 6, 4}}, 0)) << "two fans";
  EXPECT_FALSE(is_closed_fan({{0, 0, 1}}, 0)) << "a triangle has the vertex twice";
  EXPECT_TRUE(is_closed_fan({{0, 1, 2}, {0, 2, 1}}, 0)) << "two back to back";
}

}  // namespace
}  // namespace isoextract::mesh

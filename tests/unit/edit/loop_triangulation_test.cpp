#include "edit/detail/loop_triangulation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "mesh/exact_sign.hpp"

namespace isoextract::edit {
namespace {

struct PlanarLoops {
  std::vector<glm::dvec2> points;
  std::vector<std::uint32_t> next;

  void add(const std::vector<glm::dvec2>& loop) {
    const auto first = static_cast<std::uint32_t>(points.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      points.emplace_back(glm::vec2(loop[i]));
      next.push_back(first + static_cast<std::uint32_t>((i + 1) % loop.size()));
    }
  }
  void add_circle(const glm::dvec2& center, double radius, int count, bool hole) {
    std::vector<glm::dvec2> loop;
    for (int i = 0; i < count; ++i) {
      const double angle = (hole ? -2 : 2) * std::numbers::pi * i / count;
      loop.push_back(center + radius * glm::dvec2(std::cos(angle), std::sin(angle)));
    }
    add(loop);
  }
  [[nodiscard]] double area() const {
    double twice = 0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const glm::dvec2 a = points[p];
      const glm::dvec2 b = points[next[p]];
      twice += a.x * b.y - a.y * b.x;
    }
    return twice / 2;
  }
};

LoopTriangles must_triangulate(const PlanarLoops& loops,
                               const std::vector<std::pair<std::uint32_t, std::uint32_t>>& taken = {}) {
  auto result = triangulate_loops(loops.points, loops.next, taken, 0, Context());
  if (!result) throw std::runtime_error(result.error().message);
  return *result;
}

std::vector<glm::dvec2> all_points(const PlanarLoops& loops, const LoopTriangles& made) {
  std::vector<glm::dvec2> points = loops.points;
  for (const auto& [a, b] : made.midpoints) points.push_back((points[a] + points[b]) / 2.0);
  return points;
}

// Expects one triangle at every loop edge and two at every other edge, in opposite directions.
void expect_closing(const PlanarLoops& loops, const LoopTriangles& made, const std::string& what) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> uses;
  for (const glm::uvec3& t : made.triangles) {
    for (int i = 0; i < 3; ++i) ++uses[{t[i], t[(i + 1) % 3]}];
  }
  std::size_t boundary_edges = 0;
  for (const auto& [edge, count] : uses) {
    ASSERT_EQ(count, 1) << what;
    ASSERT_NE(edge.first, edge.second) << what;
    if (uses.contains({edge.second, edge.first})) continue;
    ++boundary_edges;
    ASSERT_LT(edge.first, loops.next.size()) << what;
    ASSERT_EQ(loops.next[edge.first], edge.second) << what;
  }
  ASSERT_EQ(boundary_edges, loops.points.size()) << what;
}

// Also expects the triangles to cover the region on the left of the loops once.
void expect_filling(const PlanarLoops& loops, const LoopTriangles& made, const std::string& what, bool none_flat) {
  expect_closing(loops, made, what);
  const std::vector<glm::dvec2> points = all_points(loops, made);
  double area = 0;
  std::size_t flat = 0;
  for (const glm::uvec3& t : made.triangles) {
    const glm::dvec2 u = points[t.y] - points[t.x];
    const glm::dvec2 v = points[t.z] - points[t.x];
    area += (u.x * v.y - u.y * v.x) / 2;
    const int turn = mesh::orientation_2d(points[t.x], points[t.y], points[t.z]);
    ASSERT_GE(turn, 0) << what;
    flat += turn == 0 ? 1 : 0;
  }
  EXPECT_EQ(made.turned, 0U) << what;
  EXPECT_NEAR(area, loops.area(), 1e-9 * (1 + loops.area())) << what;
  EXPECT_TRUE(!none_flat || flat == 0) << what;
}

TEST(LoopTriangulation, FillsNestedCircles) {
  PlanarLoops loops;
  for (const double x : {-3.0, 3.0}) {
    loops.add_circle({x, 0}, 2.5, 100, false);
    loops.add_circle({x, 0}, 2, 70, true);
    loops.add_circle({x + 0.5, 0.2}, 1, 50, false);
    loops.add_circle({x + 0.4, 0.2}, 0.25, 20, true);
    loops.add_circle({x + 0.9, 0.1}, 0.2, 9, true);
    loops.add_circle({x + 0.9, 0.1}, 0.1, 5, false);
  }
  const LoopTriangles made = must_triangulate(loops);
  expect_filling(loops, made, "circles", true);
  EXPECT_TRUE(made.midpoints.empty());
  // A polygon with n points and h holes has n + 2 h - 2 triangles.
  const std::size_t polygons = 2 * ((100 + 70 + 2 - 2) + (50 + 20 + 9 + 4 - 2) + (5 - 2));
  EXPECT_EQ(made.triangles.size(), polygons);
}

// The outline of random chessboard squares: many collinear points and loops that touch in points. Each touching point
// may separate or join the squares.
PlanarLoops outlines_of_squares(std::mt19937& random, int size, double share, bool joined) {
  std::vector<char> taken(static_cast<std::size_t>(size) * size);
  for (char& square : taken) square = static_cast<char>(std::bernoulli_distribution(share)(random));
  const auto is_taken = [&](int x, int y) {
    return x >= 0 && y >= 0 && x < size && y < size && taken[static_cast<std::size_t>(y) * size + x] != 0;
  };
  // For each corner, each direction: east, north, west, south. The filled square is on the left.
  const int dx[] = {1, 0, -1, 0};
  const int dy[] = {0, 1, 0, -1};
  const auto is_outline = [&](int x, int y, int d) {
    const int left_x[] = {x, x - 1, x - 1, x};
    const int left_y[] = {y, y, y - 1, y - 1};
    const int right = (d + 3) % 4;
    return is_taken(left_x[d], left_y[d]) && !is_taken(left_x[right], left_y[right]);
  };
  PlanarLoops loops;
  std::map<std::array<int, 3>, bool> seen;
  for (int y = 0; y <= size; ++y) {
    for (int x = 0; x <= size; ++x) {
      for (int d = 0; d < 4; ++d) {
        if (!is_outline(x, y, d) || seen[{x, y, d}]) continue;
        std::vector<glm::dvec2> loop;
        int at_x = x, at_y = y, along = d;
        while (!seen[{at_x, at_y, along}]) {
          seen[{at_x, at_y, along}] = true;
          loop.emplace_back(at_x, at_y);
          at_x += dx[along];
          at_y += dy[along];
          // Squares that touch in a corner stay separate or are joined there.
          for (const int turn : joined ? std::array{3, 0, 1} : std::array{1, 0, 3}) {
            const int other = (along + turn) % 4;
            if (!is_outline(at_x, at_y, other)) continue;
            along = other;
            break;
          }
        }
        loops.add(loop);
      }
    }
  }
  return loops;
}

TEST(LoopTriangulation, FillsTouchingSquares) {
  std::mt19937 random(1);
  for (int i = 0; i < 600; ++i) {
    const int size = 2 + i % 19;
    const double share = 0.3 + 0.1 * (i % 6);
    const std::string what = "squares " + std::to_string(i);
    const PlanarLoops apart = outlines_of_squares(random, size, share, false);
    expect_filling(apart, must_triangulate(apart), what, true);
    const PlanarLoops joined = outlines_of_squares(random, size, share, true);
    expect_filling(joined, must_triangulate(joined), what, false);
    if (HasFatalFailure()) return;
  }
}

// Integer samples give such surfaces: coincident points, and edges there and back.
TEST(LoopTriangulation, FillsLoopsWithCoincidentPoints) {
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const PlanarLoops plain = outlines_of_squares(random, 3 + i % 11, 0.6, i % 2 == 1);
    PlanarLoops loops;
    std::vector<bool> seen(plain.points.size());
    for (std::uint32_t first = 0; first < plain.points.size(); ++first) {
      std::vector<glm::dvec2> loop;
      for (std::uint32_t p = first; !seen[p]; p = plain.next[p]) {
        seen[p] = true;
        const int copies = std::uniform_int_distribution(1, 4)(random);
        for (int c = 0; c < copies; ++c) loop.push_back(plain.points[p]);
        if (copies == 4) {  // a spike
          loop.push_back((plain.points[p] + plain.points[plain.next[p]]) / 2.0);
          loop.push_back(plain.points[p]);
        }
      }
      if (!loop.empty()) loops.add(loop);
    }
    // Loops without area, some inside the polygon.
    loops.add({{1, 1}, {1, 1}, {1, 1}});
    loops.add({{0.5, 0.5}, {2.5, 0.5}, {1.5, 0.5}, {0.75, 0.5}});
    expect_filling(loops, must_triangulate(loops), "places " + std::to_string(i), false);
    if (HasFatalFailure()) return;
  }
}

TEST(LoopTriangulation, FlipsToDelaunay) {
  PlanarLoops loops;
  loops.add({{0, 0}, {4, 0}, {8, 0}, {8, 1}, {4, 1.25}, {0, 1}});
  const LoopTriangles made = must_triangulate(loops);
  expect_filling(loops, made, "strip", true);
  const auto has = [&](std::uint32_t a, std::uint32_t b) {
    return std::ranges::any_of(made.triangles, [&](const glm::uvec3& t) {
      return (t.x == a || t.y == a || t.z == a) && (t.x == b || t.y == b || t.z == b);
    });
  };
  EXPECT_TRUE(has(1, 4));  // the shorter diagonal
}

// An edge that exists already gets a midpoint.
TEST(LoopTriangulation, SplitsDuplicateEdges) {
  PlanarLoops loops;
  loops.add({{0, 0}, {2, -1}, {4, 0}, {2, 1}});
  const LoopTriangles made = must_triangulate(loops, {{1, 3}});
  ASSERT_EQ(made.midpoints.size(), 1U);
  EXPECT_EQ(made.midpoints[0], std::pair(1U, 3U));
  EXPECT_EQ(made.triangles.size(), 4U);
  expect_filling(loops, made, "parted", true);
  EXPECT_TRUE(must_triangulate(loops, {{0, 2}}).midpoints.empty());
}

// Loops that cross or run clockwise are closed, too, and their overlaps are counted.
TEST(LoopTriangulation, ClosesCrossingLoopsAndCountsOverlaps) {
  PlanarLoops crossing;
  crossing.add({{0, 0}, {2, 2}, {2, 0}, {0, 2}, {-1, 1}});
  PlanarLoops turned;
  turned.add_circle({0, 0}, 1, 12, true);
  for (const PlanarLoops* loops : {&crossing, &turned}) {
    const LoopTriangles made = must_triangulate(*loops);
    expect_closing(*loops, made, "crossing");
    EXPECT_GT(made.turned, 0U);
  }
}

TEST(LoopTriangulation, ObeysMemoryBudgetAndCancellation) {
  PlanarLoops loops;
  loops.add_circle({0, 0}, 1, 500, false);
  EXPECT_FALSE(triangulate_loops(loops.points, loops.next, {}, 0, Context(MemoryBudget(1000))));
  const Context context;
  context.cancel();
  EXPECT_EQ(triangulate_loops(loops.points, loops.next, {}, 0, context).error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace isoextract::edit

#include "mesh/self_intersections.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/join_meshes.hpp"
#include "mesh/triangle_overlap.hpp"
#include "support/exact_overlap.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::mesh {
namespace {

using test::ExactOverlap;
using test::make_mesh;
using test::WholeTriangle;

SelfIntersections find(const Mesh& mesh, const IntersectionOptions& options = {}) {
  auto found = find_self_intersections(mesh, options, Context());
  if (!found) {
    ADD_FAILURE() << found.error().message;
    return {};
  }
  return *found;
}

bool has_area(const WholeTriangle& t) {
  const glm::i64vec3 a = t[1] - t[0];
  const glm::i64vec3 b = t[2] - t[0];
  return a.y * b.z != a.z * b.y || a.z * b.x != a.x * b.z || a.x * b.y != a.y * b.x;
}

// Integer coordinates from 0 to `size`: on such a small grid, triangles touch in every possible way.
std::vector<WholeTriangle> random_triangles(std::size_t count, int size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> coordinate(0, size);
  std::vector<WholeTriangle> triangles(count);
  for (WholeTriangle& t : triangles) {
    for (glm::i64vec3& corner : t) corner = {coordinate(random), coordinate(random), coordinate(random)};
  }
  return triangles;
}

// Gives each triangle its own vertices, so that neighbors must be found by position.
Mesh soup(const std::vector<WholeTriangle>& triangles, float scale = 1) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> indices;
  for (const WholeTriangle& t : triangles) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const glm::i64vec3& corner : t) positions.push_back(glm::vec3(corner) * scale);
    indices.emplace_back(first, first + 1, first + 2);
  }
  return make_mesh("soup", positions, indices);
}

std::size_t shared_corners(const WholeTriangle& p, const WholeTriangle& q) {
  return static_cast<std::size_t>(
      std::ranges::count_if(p, [&](const auto& corner) { return std::ranges::find(q, corner) != q.end(); }));
}

// Tests all pairs one by one.
SelfIntersections by_force(const std::vector<WholeTriangle>& triangles) {
  SelfIntersections found;
  std::set<std::uint32_t> met;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    if (!has_area(triangles[i])) {
      ++found.zero_area_triangles;
      continue;
    }
    bool is_copy = false;
    for (std::uint32_t j = 0; j < i; ++j) is_copy = is_copy || shared_corners(triangles[i], triangles[j]) == 3;
    found.duplicate_triangles += is_copy ? 1 : 0;
    for (std::uint32_t j = i + 1; j < triangles.size(); ++j) {
      if (!has_area(triangles[j]) || shared_corners(triangles[i], triangles[j]) == 3) continue;
      if (!ExactOverlap::meet(triangles[i], triangles[j])) continue;
      ++found.pairs;
      found.neighbors += shared_corners(triangles[i], triangles[j]) > 0 ? 1 : 0;
      met.insert({i, j});
      if (found.examples.size() < 5) found.examples.push_back({i, j});
    }
  }
  found.triangles = met.size();
  return found;
}

void expect_same(const SelfIntersections& a, const SelfIntersections& b) {
  EXPECT_EQ(a.pairs, b.pairs);
  EXPECT_EQ(a.at_least, b.at_least);
  EXPECT_EQ(a.in_one_plane, b.in_one_plane);
  EXPECT_EQ(a.neighbors, b.neighbors);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.examples, b.examples);
  EXPECT_EQ(a.zero_area_triangles, b.zero_area_triangles);
  EXPECT_EQ(a.duplicate_triangles, b.duplicate_triangles);
}

// An n x n grid of squares in a plane with the given normal direction.
Mesh flat_grid(unsigned n, const glm::vec3& right, const glm::vec3& up) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (unsigned j = 0; j <= n; ++j) {
    for (unsigned i = 0; i <= n; ++i) positions.push_back(static_cast<float>(i) * right + static_cast<float>(j) * up);
  }
  for (unsigned j = 0; j < n; ++j) {
    for (unsigned i = 0; i < n; ++i) {
      const unsigned v = j * (n + 1) + i;
      triangles.insert(triangles.end(), {{v, v + 1, v + n + 2}, {v, v + n + 2, v + n + 1}});
    }
  }
  return make_mesh("grid", positions, triangles);
}

TEST(TriangleOverlapTest, MatchesRationalArithmetic) {
  std::map<std::pair<std::size_t, bool>, int> seen;  // shared corners, and whether they meet
  std::array<int, 3> rejected{};                     // by the plane of the first triangle, by shared corners
  for (const int size : {1, 2, 3, 8}) {
    const auto triangles = random_triangles(900, size, static_cast<unsigned>(size));
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const WholeTriangle& p = triangles[i];
        const WholeTriangle& q = triangles[j];
        const std::size_t shared = shared_corners(p, q);
        if (shared == 3 || !has_area(p) || !has_area(q)) continue;
        const auto placed = [](const WholeTriangle& t) {
          PlacedTriangle result;
          for (std::size_t c = 0; c < 3; ++c) result.corners[c] = glm::dvec3(t[c]);
          return result;
        };
        const bool expected = ExactOverlap::meet(p, q);
        const TriangleOverlap found = find_overlap(placed(p), placed(q));
        ASSERT_EQ(found.meet, expected) << "size " << size << ", triangles " << i << " and " << j;
        ASSERT_EQ(find_overlap(placed(q), placed(p)).meet, expected);
        const auto corners = [](const WholeTriangle& t) {
          return std::array{glm::vec3(t[0]), glm::vec3(t[1]), glm::vec3(t[2])};
        };
        const bool is_rejected = PlaneFilter(corners(p)).is_apart(CornerLanes(corners(q)));
        ASSERT_FALSE(is_rejected && expected) << "size " << size << ", triangles " << i << " and " << j;
        rejected[shared] += is_rejected ? 1 : 0;
        if (found.meet) {
          ASSERT_EQ(found.neighbors, shared > 0);
          bool flat = true;
          const glm::i64vec3 normal = glm::cross(glm::dvec3(p[1] - p[0]), glm::dvec3(p[2] - p[0]));
          for (const glm::i64vec3& corner : q) {
            const glm::i64vec3 way = corner - p[0];
            flat = flat && normal.x * way.x + normal.y * way.y + normal.z * way.z == 0;
          }
          ASSERT_EQ(found.in_one_plane, flat);
        }
        ++seen[{shared, expected}];
      }
    }
  }
  for (const std::size_t shared : {0U, 1U, 2U}) {
    EXPECT_GT((seen[{shared, false}]), 100) << shared;
    EXPECT_GT((seen[{shared, true}]), 100) << shared;
    EXPECT_GT(rejected[shared], (seen[{shared, false}]) / 4) << shared;
  }
}

// Triangles around a corner, around a side, and others, so that stars and the triangles crossing them occur.
TEST(SelfIntersectionsTest, MatchesBruteForceAroundCrowdedPlaces) {
  for (const int size : {3, 9, 40}) {
    auto triangles = random_triangles(450, size, 100 + static_cast<unsigned>(size));
    for (std::size_t i = 0; i < 150; ++i) triangles[i][i % 3] = glm::i64vec3(0);
    for (std::size_t i = 150; i < 300; ++i) {
      triangles[i][i % 3] = glm::i64vec3(0, 0, size);
      triangles[i][(i + 1) % 3] = glm::i64vec3(size, 1, 0);
    }
    SelfIntersections expected = by_force(triangles);
    EXPECT_GT(expected.pairs, 1000U);
    for (const float scale : {1.0F, 0x1p-140F, 0x1p110F}) {
      const SelfIntersections found = find(soup(triangles, scale));
      EXPECT_EQ(found.pairs, expected.pairs) << "size " << size;
      EXPECT_EQ(found.neighbors, expected.neighbors);
      EXPECT_EQ(found.zero_area_triangles, expected.zero_area_triangles);
      EXPECT_EQ(found.duplicate_triangles, expected.duplicate_triangles);
      EXPECT_LE(found.looked_at, 450U * 449U / 2);
    }
  }
}

// n triangles around one vertex (a cone) or around one edge.
Mesh crowd(unsigned n, char kind) {
  std::vector<glm::vec3> positions{{0, 0, 1}, {0.1F, 0.2F, -1}};
  std::vector<glm::uvec3> triangles;
  for (unsigned i = 0; i < n; ++i) {
    const double angle = 2 * std::numbers::pi * i / n;
    positions.emplace_back(std::cos(angle), std::sin(angle), 0.3 * std::cos(angle));
    const unsigned v = 2 + i;
    const unsigned next = 2 + (i + 1) % n;
    triangles.push_back(kind == 'e' ? glm::uvec3(0, 1, v) : glm::uvec3(0, v, next));
  }
  return make_mesh("crowd", positions, triangles);
}

TEST(SelfIntersectionsTest, ScalesLinearlyAroundOnePlace) {
  for (const char kind : {'v', 'e'}) {
    std::array<std::uint64_t, 2> looked_at{};
    for (const unsigned doubled : {0U, 1U}) {
      const Mesh mesh = crowd(5000U << doubled, kind);
      const SelfIntersections found = find(mesh);
      EXPECT_EQ(found.pairs, 0U) << kind;
      looked_at[doubled] = found.looked_at;
    }
    EXPECT_LE(looked_at[0], 5000U * 20) << kind;  // of 12 million pairs
    EXPECT_LE(looked_at[1], looked_at[0] * 5 / 2) << kind;
  }
}

TEST(SelfIntersectionsTest, MatchesBruteForceOnRandomSoups) {
  for (const int size : {2, 5, 20, 60}) {
    const auto triangles = random_triangles(400, size, 7 + static_cast<unsigned>(size));
    SelfIntersections expected = by_force(triangles);
    for (const float scale : {1.0F, 0x1p-140F, 0x1p110F}) {  // 1, subnormal numbers, 1e33
      const SelfIntersections found = find(soup(triangles, scale));
      expected.in_one_plane = found.in_one_plane;  // compared with itself: MatchesRationalArithmetic tests it
      // With duplicates, the examples name the first copy of each triangle.
      if (expected.duplicate_triangles > 0) {
        expected.examples = found.examples;
        expected.triangles = found.triangles;
      }
      expect_same(found, expected);
    }
  }
}

TEST(SelfIntersectionsTest, FindsNoneInSphere) {
  const SelfIntersections found = find(test::sphere(60, false));
  EXPECT_EQ(found.pairs, 0U);
  EXPECT_EQ(found.zero_area_triangles + found.duplicate_triangles, 0U);
  EXPECT_TRUE(found.examples.empty());
}

TEST(SelfIntersectionsTest, FindsPlantedIntersections) {
  // One moved vertex makes a spike through the far side of a sphere.
  Mesh mesh = test::sphere(20, false);
  const std::size_t moved = 1 + 9 * 40;
  mesh.positions[moved] = mesh.positions[moved] * -1.5F;
  const SelfIntersections found = find(mesh);
  EXPECT_GE(found.pairs, 6U);
  EXPECT_EQ(found.in_one_plane, 0U);
  for (const auto& [i, j] : found.examples) {
    EXPECT_LT(i, j);
    const auto has_moved = [&](std::uint32_t t) {
      const glm::uvec3& triangle = mesh.triangles[t];
      return triangle.x == moved || triangle.y == moved || triangle.z == moved;
    };
    EXPECT_TRUE(has_moved(i) || has_moved(j));
  }
  // A corner exactly on a face touches it; a corner just above does not.
  const std::vector<glm::vec3> face{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  for (const auto& [z, pairs] : {std::pair{0.0F, 1U}, std::pair{0x1p-149F, 0U}, std::pair{-0x1p-149F, 1U}}) {
    std::vector<glm::vec3> positions = face;
    positions.insert(positions.end(), {{1, 1, z}, {2, 1, 1}, {1, 2, 1}});
    EXPECT_EQ(find(make_mesh("touch", positions, {{0, 1, 2}, {3, 4, 5}})).pairs, pairs) << z;
  }
}

TEST(SelfIntersectionsTest, FindsFoldedNeighbors) {
  const std::vector<glm::vec3> positions{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 1, 0}, {1, -1, 0}};
  const SelfIntersections folded = find(make_mesh("fold", positions, {{0, 1, 2}, {1, 0, 3}}));
  EXPECT_EQ(folded.pairs, 1U);
  EXPECT_EQ(folded.in_one_plane, 1U);
  EXPECT_EQ(folded.neighbors, 1U);
  EXPECT_EQ(find(make_mesh("flat", positions, {{0, 1, 2}, {1, 0, 4}})).pairs, 0U);
}

TEST(SelfIntersectionsTest, HandlesManyCoplanarTriangles) {
  for (const auto& [right, up] :
       {std::pair{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0)}, std::pair{glm::vec3(1, 0, 1), glm::vec3(0, 1, -1)}}) {
    Mesh mesh = flat_grid(300, right, up);
    EXPECT_EQ(find(mesh).pairs, 0U);
    // Twice at the same place: every triangle is a duplicate, and no pair counts.
    std::vector<Mesh> two(2);
    two[0] = flat_grid(60, right, up);
    two[1] = flat_grid(60, right, up);
    const SelfIntersections found = find(*join_meshes(two, Context()));
    EXPECT_EQ(found.pairs, 0U);
    EXPECT_EQ(found.duplicate_triangles, 60U * 60 * 2);
    // Moved by half a square, they overlap.
    for (glm::vec3& p : two[1].positions) p += 0.5F * right;
    const SelfIntersections moved = find(*join_meshes(two, Context()));
    EXPECT_GT(moved.pairs, 60U * 60 * 4);
    EXPECT_EQ(moved.in_one_plane, moved.pairs);
  }
}

TEST(SelfIntersectionsTest, CountsEveryCopy) {
  constexpr unsigned kCopies = 50000;
  std::vector<glm::uvec3> triangles(kCopies, glm::uvec3(0, 1, 2));
  for (std::size_t i = 0; i < kCopies; i += 2) triangles[i] = {2, 1, 0};
  triangles.emplace_back(3, 4, 5);
  triangles.emplace_back(3, 3, 5);  // zero area
  const SelfIntersections found =
      find(make_mesh("copies", {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 1, 1}}, triangles));
  EXPECT_EQ(found.pairs, kCopies);
  EXPECT_EQ(found.triangles, 2U);
  EXPECT_EQ(found.duplicate_triangles, kCopies - 1);
  EXPECT_EQ(found.zero_area_triangles, 1U);
  EXPECT_EQ(found.examples, (std::vector<std::array<std::uint32_t, 2>>{{0, kCopies}}));
}

TEST(SelfIntersectionsTest, StopsAtMostPairs) {
  const Mesh mesh = soup(random_triangles(3000, 50, 3));
  const SelfIntersections all = find(mesh);
  ASSERT_GT(all.pairs, 1000U);
  ASSERT_FALSE(all.at_least);
  for (const std::size_t threads : {1U, 4U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    IntersectionOptions options;
    options.most_pairs = 100;
    const SelfIntersections some = find(mesh, options);
    EXPECT_TRUE(some.at_least);
    EXPECT_EQ(some.pairs, 100U);
    EXPECT_EQ(some.examples, all.examples);
    options.most_pairs = all.pairs;
    EXPECT_FALSE(find(mesh, options).at_least);
  }
}

TEST(SelfIntersectionsTest, IsIndependentOfThreads) {
  const Mesh mesh = soup(random_triangles(4000, 400, 5));
  const auto with_threads = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return find(mesh);
  };
  const SelfIntersections one = with_threads(1);
  EXPECT_GT(one.pairs, 0U);
  for (const std::size_t threads : {2U, 4U, 7U}) expect_same(with_threads(threads), one);
}

TEST(SelfIntersectionsTest, HandlesTrivialMeshes) {
  expect_same(find(make_mesh("empty", {}, {})), {});
  expect_same(find(make_mesh("one", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}})), {});
  const SelfIntersections line = find(make_mesh("line", {{0, 0, 0}, {1, 1, 1}, {3, 3, 3}}, {{0, 1, 2}}));
  EXPECT_EQ(line.zero_area_triangles, 1U);
}

TEST(SelfIntersectionsTest, ObeysCancellationAndMemoryBudget) {
  const Mesh mesh = test::sphere(60, false);
  const Context cancelled;
  cancelled.cancel();
  const auto ended = find_self_intersections(mesh, {}, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
  const auto refused = find_self_intersections(mesh, {}, Context(MemoryBudget(10000)));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::mesh

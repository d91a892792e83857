#include "mesh/shells.hpp"

#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/exact_sign.hpp"
#include "mesh/join_meshes.hpp"
#include "mesh/metrics.hpp"
#include "support/box_mesh.hpp"
#include "support/sample_meshes.hpp"

namespace isoextract::mesh {
namespace {

// The direction of the rays, and two directions across it.
const glm::vec3 kWay(8112, 4361, 3897);
const glm::vec3 kAcross(-4361, 8112, 0);
const glm::vec3 kUp(0, -3897, 4361);

Mesh cube(float half, const glm::vec3& center = glm::vec3(0)) { return test::box_mesh(center - half, center + half); }

Mesh turned(Mesh mesh) {
  for (glm::uvec3& t : mesh.triangles) std::swap(t.y, t.z);
  return mesh;
}

// A cube whose farthest corner along the rays is `tip`.
Mesh cube_with_tip(const glm::vec3& tip) { return test::box_mesh(tip - 1.0F, tip); }

std::vector<Surroundings> surroundings_of(std::vector<Mesh> shells, bool test_outward = true) {
  const Mesh mesh = std::move(*join_meshes(shells, Context()));
  const Components components(mesh.triangles.span(), mesh.positions.size());
  ShellQuery question{.test_outward = test_outward, .find_open = true};
  for (const Mesh& shell : shells) {
    const double volume = measure_size(shell).volume;
    question.facing.push_back(shell.triangles.size() % 2 == 1 ? Facing::open
                              : volume < 0                    ? Facing::inward
                                                              : Facing::outward);
  }
  EXPECT_EQ(components.count(), shells.size());
  auto found = find_enclosing_shells(mesh, components, question, Context());
  EXPECT_TRUE(found);
  return found ? std::move(*found) : std::vector<Surroundings>(shells.size());
}

template <class... Meshes>
std::vector<Surroundings> surroundings(Meshes... meshes) {
  std::vector<Mesh> list;
  (list.push_back(std::move(meshes)), ...);
  return surroundings_of(std::move(list));
}

Mesh octahedron(const glm::vec3& center, float radius) {
  std::vector<glm::vec3> at{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  for (glm::vec3& p : at) p = p * radius + center;
  return test::make_mesh("octahedron", at,
                         {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
}

using Numbers = std::vector<std::uint32_t>;

TEST(Shells, FindsSurroundingShells) {
  const auto found = surroundings(cube(3), turned(cube(1)), cube(2), cube(1, {9, 0, 0}));
  EXPECT_EQ(found[0].around, Numbers());
  EXPECT_EQ(found[1].around, (Numbers{0, 2}));
  EXPECT_EQ(found[2].around, (Numbers{0}));
  EXPECT_EQ(found[3].around, Numbers());
  std::vector<Mesh> list;
  list.push_back(cube(3));
  list.push_back(turned(cube(1)));
  list.push_back(cube(2));
  const auto inward = surroundings_of(std::move(list), false);
  EXPECT_EQ(inward[1].around, (Numbers{0, 2}));
  EXPECT_EQ(inward[2].around, Numbers()) << "not asked for";
}

// Shells that face inward, one behind the other: neither contains the other, whatever the ray meets first.
TEST(Shells, BubblesInRowDoNotContainEachOther) {
  const auto found = surroundings(turned(cube(1)), turned(cube(1, kWay / 1000.0F)), cube(1, kWay / 500.0F));
  for (const Surroundings& one : found) {
    EXPECT_EQ(one.around, Numbers());
    EXPECT_EQ(one.open, Components::kNone);
  }
}

TEST(Shells, FindsOpenComponentBehindBubbles) {
  Mesh open = cube(20);
  Buffer<glm::uvec3> left(11);  // all triangles but one on the near side
  std::copy(open.triangles.begin() + 1, open.triangles.end(), left.begin());
  open.triangles = std::move(left);
  const auto found = surroundings(turned(cube(1)), turned(cube(1, kWay / 1000.0F)), cube(1, -kWay / 1000.0F),
                                  std::move(open), turned(cube(1, {40, 0, 0})));
  for (const Surroundings& one : found) EXPECT_EQ(one.around, Numbers());
  EXPECT_EQ(found[0].open, 3U);
  EXPECT_EQ(found[1].open, 3U);
  EXPECT_EQ(found[2].open, Components::kNone) << "it faces outward";
  EXPECT_EQ(found[4].open, Components::kNone) << "behind it";
}

// Tetrahedra with corners, edges and sides on the ray.
TEST(Shells, DecidesRaysThroughCornersAndEdges) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> part(-2, 2);
  const glm::vec3 tip(7, -3, 11);
  int inside = 0;
  int outside = 0;
  int touching = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto corner = [&] {
      return tip + static_cast<float>(part(random)) * kWay + static_cast<float>(part(random)) * kAcross +
             static_cast<float>(part(random)) * kUp;
    };
    std::vector<glm::vec3> at{corner(), corner(), corner(), corner()};
    const std::vector<glm::uvec3> triangles{{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
    const auto side = [&](const glm::uvec3& t, const glm::vec3& p) {
      return orientation_3d(glm::dvec3(at[t.x]), glm::dvec3(at[t.y]), glm::dvec3(at[t.z]), glm::dvec3(p));
    };
    if (side({0, 1, 2}, at[3]) == 0) continue;
    if (side({0, 1, 2}, at[3]) < 0) std::swap(at[0], at[1]);
    int most = -1;  // the greatest orientation_3d() of the tip
    for (const glm::uvec3& t : triangles) most = std::max(most, side(t, tip));
    (most < 0 ? inside : most > 0 ? outside : touching) += 1;
    if (most == 0) continue;
    const auto found = surroundings(test::make_mesh("tetrahedron", at, triangles), cube_with_tip(tip));
    ASSERT_EQ(found[1].around, most < 0 ? Numbers{0} : Numbers()) << i;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(outside, 1000);
  EXPECT_GT(touching, 1000);
}

// The start vertex of the ray is a corner of the other shell, or lies on one of its edges or sides.
TEST(Shells, DecidesTouchingShellsBesideTheirVertex) {
  // Its farthest vertex is the one along x.
  for (const glm::vec3& tip : {glm::vec3(0), glm::vec3(0, 4, 0), glm::vec3(0, 4, 4), glm::vec3(0, 1, 3)}) {
    const auto within =
        surroundings(octahedron(tip - glm::vec3(0.5F, 0, 0), 0.5F), test::box_mesh({-8, -4, -4}, {0, 4, 4}));
    if (std::abs(tip.y) + 0.5F < 4 && std::abs(tip.z) + 0.5F < 4) {
      EXPECT_EQ(within[0].around, (Numbers{1}));
    }
    EXPECT_EQ(within[1].around, Numbers());
    const auto beside =
        surroundings(octahedron(tip - glm::vec3(0.5F, 0, 0), 0.5F), test::box_mesh({0, -4, -4}, {8, 4, 4}));
    EXPECT_EQ(beside[0].around, Numbers());
    EXPECT_EQ(beside[1].around, Numbers());
  }
}

// The cube lies in the box of the octahedron, so its ray continues to the end of that box. There it is inside another
// cube, outside all, or behind it.
TEST(Shells, IgnoresShellsWhereRayEnds) {
  const glm::vec3 tip(0, 5, 5);
  for (float far = 0; far < 12; far += 0.125F) {
    const glm::vec3 center = tip + (2.0F + far) * glm::normalize(kWay);
    const auto found =
        surroundings(octahedron(glm::vec3(0), 8), cube_with_tip(tip), cube(1.5F, center), cube(0.5F, center));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(found[i].around, Numbers()) << i << ' ' << far;
    EXPECT_EQ(found[3].around, Numbers{2});
  }
}

// Many rays and triangles must not be compared pair by pair.
TEST(Shells, HandlesLongRowsAlongRays) {
  constexpr std::uint32_t kCount = 30'000;
  std::vector<Mesh> row;
  for (std::uint32_t i = 0; i < kCount; ++i) row.push_back(cube(0.5F, static_cast<float>(i) / 2048 * kWay));
  row.push_back(turned(cube(0.25F)));
  const auto found = surroundings_of(std::move(row));
  for (std::uint32_t i = 0; i < kCount; ++i) ASSERT_EQ(found[i].around, Numbers());
  EXPECT_EQ(found[kCount].around, (Numbers{0}));
}

TEST(Shells, DoesNotDependOnThreadsAndKeepsToMemory) {
  std::vector<Mesh> list;
  std::mt19937 random(8);
  for (unsigned i = 0; i < 400; ++i) {
    const glm::vec3 center(random() % 9, random() % 9, random() % 9);
    list.push_back(cube(static_cast<float>(1 + random() % 7) / 2, center));
    if (i % 2 == 0) list.back() = turned(std::move(list.back()));
  }
  const Mesh mesh = std::move(*join_meshes(list, Context()));
  const Components components(mesh.triangles.span(), mesh.positions.size());
  ShellQuery question;
  for (unsigned i = 0; i < list.size(); ++i) question.facing.push_back(i % 2 == 0 ? Facing::inward : Facing::outward);
  std::vector<std::vector<Surroundings>> results;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(find_enclosing_shells(mesh, components, question, Context()).value());
  }
  std::size_t most = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    EXPECT_EQ(results[0][i].around, results[1][i].around);
    most = std::max(most, results[0][i].around.size());
  }
  EXPECT_GT(most, 10U);
  const auto little = find_enclosing_shells(mesh, components, question, Context(MemoryBudget(1000)));
  ASSERT_FALSE(little);
  EXPECT_EQ(little.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  const Context cancelled;
  cancelled.cancel();
  const auto ended = find_enclosing_shells(mesh, components, question, cancelled);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
}

}  // namespace
}  // namespace isoextract::mesh

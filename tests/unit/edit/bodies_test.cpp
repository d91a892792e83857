#include "edit/bodies.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "mesh/component_facts.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"
#include "support/sample_attributes.hpp"

namespace isoextract::edit {
namespace {

struct Ball {
  glm::dvec3 center;
  double radius;
};

// Inside is where an odd number of balls overlap: a ball in a ball is a cavity, a ball in a cavity a loose body.
field::ScalarField nested(const std::vector<Ball>& balls, const glm::ivec3& dims = glm::ivec3(48)) {
  return test::dense_field<float>(dims, [&](int i, int j, int k) {
    double value = -1;  // signed distance to the nearest sphere
    double nearest = 1e9;
    int around = 0;
    for (const Ball& ball : balls) {
      const double depth = ball.radius - glm::length(glm::dvec3(i, j, k) - ball.center);
      around += depth > 0 ? 1 : 0;
      nearest = std::min(nearest, std::abs(depth));
    }
    value = around % 2 == 1 ? nearest : -nearest;
    return value;
  });
}

mesh::Mesh surface_of(const field::ScalarField& field, bool cap = false) {
  extract::ExtractOptions options;
  options.iso = 0;
  options.cap = cap;
  options.smooth_normals = true;
  return std::move(test::extract(field, options).mesh);
}

SelectedBodies must_keep(const mesh::Mesh& mesh, const BodySelection& options) {
  auto kept = select_bodies(copy(mesh), options, Context());
  if (!kept) throw std::runtime_error(kept.error().message);
  return std::move(*kept);
}

double volume_of(double radius) { return 4 * std::numbers::pi / 3 * radius * radius * radius; }

// A shell with a cavity that contains a pebble with a cavity, and a small ball beside the shell.
const std::vector<Ball> kShells{{{20.2, 20.3, 20.1}, 16},
                                {{20.1, 20.4, 20.2}, 11},
                                {{21.3, 19.2, 20.5}, 6},
                                {{21.1, 19.4, 20.3}, 3},
                                {{42.2, 42.1, 41.8}, 4}};

TEST(Bodies, KeepsLargestBodiesWithTheirCavities) {
  const mesh::Mesh mesh = surface_of(nested(kShells));
  BodySelection options;
  options.largest = 1;
  const auto [kept, facts] = must_keep(mesh, options);
  EXPECT_EQ(facts.before.components, 5U);
  EXPECT_EQ(facts.before.bodies, 3U);
  EXPECT_EQ(facts.after.components, 2U);
  EXPECT_EQ(facts.after.bodies, 1U);
  EXPECT_EQ(facts.after.triangles, kept.triangles.size());
  test::expect_sound(kept, true);
  EXPECT_NEAR(mesh::measure_size(kept).volume, volume_of(16) - volume_of(11), 0.02 * volume_of(16));
  options.largest = 2;
  EXPECT_EQ(must_keep(mesh, options).facts.after.components, 4U) << "and the hollow pebble";
}

TEST(Bodies, RemovesContentsOfFilledCavities) {
  const mesh::Mesh mesh = surface_of(nested(kShells));
  BodySelection options;
  options.fill_cavities = true;
  const auto [kept, facts] = must_keep(mesh, options);
  EXPECT_EQ(facts.after.components, 2U) << "the ball, filled, and the one beside it";
  EXPECT_NEAR(mesh::measure_size(kept).volume, volume_of(16) + volume_of(4), 0.02 * volume_of(16));
}

TEST(Bodies, RemovesSmallComponentsByEachMeasure) {
  const mesh::Mesh mesh = surface_of(nested(kShells));
  BodySelection options;
  options.measure = ComponentMeasure::volume;
  options.least = volume_of(3.5);  // more than the pebble's cavity
  auto kept = must_keep(mesh, options);
  EXPECT_EQ(kept.facts.after.components, 4U);
  EXPECT_EQ(kept.facts.after.bodies, 3U);
  options.least = volume_of(5);  // more than the ball, too
  EXPECT_EQ(must_keep(mesh, options).facts.after.bodies, 2U);
  options.measure = ComponentMeasure::area;
  options.least = 4 * std::numbers::pi * 7 * 7;  // more than the pebble, too
  EXPECT_EQ(must_keep(mesh, options).facts.after.components, 2U);
  options.to_metric = glm::dmat3(0.5);  // quarters areas, so the cavity is filled
  EXPECT_EQ(must_keep(mesh, options).facts.after.components, 1U);
  options.to_metric = glm::dmat3(-0.5);  // mirrored: bodies stay bodies
  EXPECT_EQ(must_keep(mesh, options).facts.after.components, 1U);
  options.measure = ComponentMeasure::triangles;
  options.least = static_cast<double>(mesh.triangles.size());
  kept = must_keep(mesh, options);
  EXPECT_TRUE(kept.mesh.triangles.empty());
  EXPECT_TRUE(kept.mesh.positions.empty());
}

TEST(Bodies, TreatsOpenComponentsAsBodiesWithoutVolume) {
  const field::ScalarField field = nested({{{0, 24, 24}, 12}, {{4, 24, 24}, 3.2}, {{30.1, 24.2, 24.3}, 4}});
  const mesh::Mesh mesh = surface_of(field);
  BodySelection options;
  options.largest = 1;
  const auto largest = must_keep(mesh, options);
  EXPECT_EQ(largest.facts.before.bodies, 2U);
  EXPECT_EQ(largest.facts.after.components, 2U) << "the open half with its cavity";
  EXPECT_EQ(largest.facts.without_volume, 0U);
  options.largest.reset();
  options.measure = ComponentMeasure::volume;
  options.least = 1e9;
  const auto open = must_keep(mesh, options);
  EXPECT_EQ(open.facts.after.components, 1U);
  EXPECT_EQ(open.facts.without_volume, 1U);
  EXPECT_GT(mesh::measure_topology(open.mesh).open_edges, 0U);
}

// Bubbles in unbounded matter: each is a body. In one case the rays of mesh/shells.hpp from one bubble pass through the
// other.
TEST(Bodies, TreatsCavitiesWithoutShellAsBodies) {
  for (const glm::dvec3& other : {glm::dvec3(28.1, 28.2, 28.3), glm::dvec3(28.1, 20.9, 19.8)}) {
    const field::ScalarField field = test::dense_field<float>(glm::ivec3(40), [&](int i, int j, int k) {
      const glm::dvec3 p(i, j, k);
      return std::min(glm::length(p - glm::dvec3(12.1, 12.2, 12.3)) - 8, glm::length(p - other) - 5);
    });
    const mesh::Mesh mesh = surface_of(field);
    BodySelection options;
    options.largest = 1;
    const auto [kept, facts] = must_keep(mesh, options);
    EXPECT_EQ(facts.before.bodies, 2U);
    EXPECT_EQ(facts.after.components, 1U);
    EXPECT_NEAR(mesh::measure_size(kept).volume, -volume_of(8), 0.05 * volume_of(8));
    options = BodySelection();
    options.fill_cavities = true;
    EXPECT_EQ(must_keep(mesh, options).facts.after.bodies, 2U);
    EXPECT_EQ(split_into_bodies(copy(mesh), 2, Context()).value().size(), 2U);
  }
}

// A grain with a cavity, in a bubble. The matter around it is open at the data boundary, or unbounded.
TEST(Bodies, AssignsCavityToInnermostGrain) {
  const field::ScalarField open =
      nested({{{0, 24, 24}, 20}, {{9.1, 24.2, 24.3}, 8}, {{9.2, 24.1, 24.4}, 6}, {{9.3, 24.4, 24.2}, 3.3}});
  const field::ScalarField without_end = test::dense_field<float>(glm::ivec3(40), [](int i, int j, int k) {
    const double d = glm::length(glm::dvec3(i, j, k) - glm::dvec3(20.1, 20.2, 20.3));
    return std::max(d - 14, std::min(9 - d, d - 5));
  });
  for (const field::ScalarField* field : {&open, &without_end}) {
    const bool is_open = field == &open;
    const mesh::Mesh mesh = surface_of(*field);
    BodySelection options;
    options.largest = 2;
    const BodyFigures facts = must_keep(mesh, options).facts;
    EXPECT_EQ(facts.before.components, is_open ? 4U : 3U);
    EXPECT_EQ(facts.before.bodies, 2U) << is_open;
    EXPECT_EQ(facts.after.components, facts.before.components) << "the grain keeps its cavity";
    const auto pieces = split_into_bodies(copy(mesh), 2, Context()).value();
    ASSERT_EQ(pieces.size(), 2U);
    EXPECT_GT(mesh::measure_size(pieces[1]).volume, 0) << "no cavity is a piece by itself";
  }
}

// Many balls, some with cavities, with known nesting.
TEST(Bodies, FindsNestingOfManyBalls) {
  std::mt19937 engine(5);
  std::vector<Ball> balls;
  std::size_t hollow = 0;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      for (int z = 0; z < 3; ++z) {
        const auto jitter = [&] { return static_cast<double>(engine() % 1000) / 2000; };
        const glm::dvec3 center(8 + 14 * x + jitter(), 8 + 14 * y + jitter(), 8 + 14 * z + jitter());
        balls.push_back({center, 6});
        if (engine() % 2 == 0) continue;
        balls.push_back({center, 3.5});
        ++hollow;
      }
    }
  }
  const mesh::Mesh mesh = surface_of(nested(balls, {92, 92, 48}));
  const auto pieces = split_into_bodies(copy(mesh), balls.size(), Context()).value();
  EXPECT_EQ(pieces.size(), balls.size() - hollow);
  std::size_t cavities = 0;
  for (const mesh::Mesh& piece : pieces) {
    const mesh::Components components(piece.triangles.span(), piece.positions.size());
    const auto facts = measure_components(piece, components, glm::dmat3(1.0), Context()).value();
    ASSERT_LE(facts.size(), 2U);
    const bool first_is_wall = facts[0].faces_inward();
    const mesh::ComponentFacts& body = facts[first_is_wall ? 1 : 0];
    EXPECT_FALSE(body.faces_inward());
    for (const mesh::ComponentFacts& shell : facts) {
      EXPECT_TRUE(shell.is_closed());
      EXPECT_EQ(shell.topology.genus(), 0);
      EXPECT_TRUE(glm::all(glm::lessThanEqual(body.bounds.min, shell.bounds.min)));
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(body.bounds.max, shell.bounds.max)));
      cavities += shell.faces_inward() ? 1 : 0;
    }
  }
  EXPECT_EQ(cavities, hollow);
}

TEST(Bodies, SplitsMeshIntoBodies) {
  mesh::Mesh mesh = surface_of(nested(kShells));
  mesh.name = "balls";
  mesh.origin = {10, 20, 30};
  test::add_attribute(mesh, "age", mesh::ComponentType::f32, 2);
  test::add_color(mesh, mesh::ComponentType::u8, 4);
  const auto pieces = split_into_bodies(copy(mesh), 3, Context());
  ASSERT_TRUE(pieces);
  ASSERT_EQ(pieces->size(), 3U);
  std::vector<std::array<test::Point, 3>> together;
  double area = 1e9;
  for (const mesh::Mesh& piece : *pieces) {
    test::expect_sound(piece, true);
    EXPECT_EQ(piece.normals.size(), piece.positions.size());
    ASSERT_EQ(piece.attributes.size(), mesh.attributes.size());
    const auto set = test::triangle_set(piece);
    together.insert(together.end(), set.begin(), set.end());
    EXPECT_LT(mesh::measure_size(piece).area, area) << "the largest first";
    area = mesh::measure_size(piece).area;
  }
  std::sort(together.begin(), together.end());
  EXPECT_EQ(together, test::triangle_set(mesh));
  EXPECT_EQ(mesh::measure_topology((*pieces)[0]).components, 2U) << "with its cavity";
  const auto many = split_into_bodies(copy(mesh), 2, Context());
  ASSERT_FALSE(many);
  EXPECT_NE(many.error().message.find("3 bodies"), std::string::npos);
  EXPECT_TRUE(split_into_bodies(mesh::Mesh(), 2, Context()).value().empty());
}

TEST(Bodies, IsIndependentOfThreadsAndReservesMemory) {
  const field::ScalarField field = test::random_field<std::uint8_t>({40, 40, 40}, 3, 256);
  extract::ExtractOptions options;
  options.iso = 200;
  options.cap = true;
  const mesh::Mesh mesh = std::move(test::extract(field, options).mesh);
  BodySelection choice;
  choice.largest = 40;
  choice.least = 12;
  std::vector<SelectedBodies> results;
  for (const std::size_t threads : {1, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    results.push_back(must_keep(mesh, choice));
  }
  EXPECT_GT(results[0].facts.before.components, 500U);
  EXPECT_EQ(results[0].facts.after.bodies, 40U);
  EXPECT_TRUE(std::ranges::equal(results[0].mesh.triangles, results[1].mesh.triangles));
  EXPECT_TRUE(std::ranges::equal(results[0].mesh.positions, results[1].mesh.positions));
  test::expect_sound(results[0].mesh, true);
  const auto little = select_bodies(copy(mesh), choice, Context(MemoryBudget(1000)));
  ASSERT_FALSE(little);
  EXPECT_EQ(little.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::edit

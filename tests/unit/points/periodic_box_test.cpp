// Tests fields and attributes of particles in periodic boxes.
#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "extract/extractor.hpp"
#include "mesh/metrics.hpp"
#include "points/attribute_sampling.hpp"
#include "points/detail/cubic_spline.hpp"
#include "support/meshes.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kBoxRadius = 0.25;

const SimulationBox kCube{{1, -2, 3}, glm::dmat3(6, 0, 0, 0, 6, 0, 0, 0, 6), {true, true, true}};
const SimulationBox kBrickBox{{1, -2, 3}, glm::dmat3(6, 0, 0, 0, 7, 0, 0, 0, 5.2), {true, true, true}};
const SimulationBox kSheared{{1, -2, 3}, glm::dmat3(6, 0, 0, 1.5, 5.5, 0, -1, 2, 5), {true, true, true}};
const SimulationBox kSlab{{1, -2, 3}, glm::dmat3(6, 0, 0, 1.5, 5.5, 0, 0, 0, 5), {true, false, false}};

FieldOptions box_options(Method method) {
  FieldOptions options;
  options.method = method;
  options.radius = kBoxRadius;
  return options;
}

ParticleSet in_box(const std::vector<glm::dvec3>& positions, const SimulationBox& box) {
  ParticleSet set = particles_at(positions);
  set.box = box;
  return set;
}

mesh::Mesh surface_in(const ParticleField& made, Method method, bool cap = false) {
  extract::ExtractOptions options;
  options.iso = method_info(method).iso;
  options.region = made.region;
  options.cap = cap;
  options.output_from_index = made.field.index_to_world;
  return test::extract(made.field, options).mesh;
}

// Returns a ball of particles around the center of the box, moved by whole samples.
std::vector<glm::dvec3> ball_in(const SimulationBox& box, const field::Affine& world_from_index,
                                const glm::dvec3& steps) {
  std::vector<glm::dvec3> positions = lattice_ball(kBoxRadius, 1.5, 0.3);
  for (glm::dvec3& p : positions) {
    p += box.world_from_fractions()(glm::dvec3(0.5)) + world_from_index.linear * steps;
  }
  return positions;
}

class PeriodicSurface : public testing::TestWithParam<std::tuple<Method, SimulationBox>> {};

TEST_P(PeriodicSurface, IsTheSameForABallAcrossFaces) {
  const auto& [method, box] = GetParam();
  const FieldOptions options = box_options(method);
  const ParticleField inside = field_of(in_box(ball_in(box, {}, glm::dvec3(0)), box), options);
  const field::Affine& map = inside.field.index_to_world;
  const mesh::Mesh whole = surface_in(inside, method);
  const mesh::MeshSize size = mesh::measure_size(whole);
  ASSERT_GT(whole.triangles.size(), 100U);
  ASSERT_GT(size.volume, 3.0);
  const glm::ivec3 cells = inside.region->max;
  for (const glm::dvec3 part : {glm::dvec3(1, 0, 0), glm::dvec3(1, 1, 0), glm::dvec3(1, 1, 1), glm::dvec3(-5, 3, 7)}) {
    glm::dvec3 steps(0);
    for (int k = 0; k < 3; ++k) {
      if (box.periodic[static_cast<std::size_t>(k)]) steps[k] = std::round(part[k] * cells[k] / 2.0);
    }
    const ParticleField made = field_of(in_box(ball_in(box, map, steps), box), options);
    EXPECT_EQ(made.region, inside.region);
    EXPECT_EQ(made.field.index_to_world, map);
    const mesh::Mesh open = surface_in(made, method);
    EXPECT_EQ(open.triangles.size(), whole.triangles.size());
    EXPECT_NEAR(mesh::measure_size(open).area, size.area, 1e-5 * size.area);
    const mesh::Mesh capped = surface_in(made, method, true);
    test::expect_sound(capped, true);
    EXPECT_NEAR(mesh::measure_size(capped).volume, size.volume, 1e-5 * size.volume);
  }
}

INSTANTIATE_TEST_SUITE_P(MethodsAndBoxes, PeriodicSurface,
                         testing::Combine(testing::Values(Method::sph, Method::anisotropic, Method::weight),
                                          testing::Values(kCube, kBrickBox, kSheared, kSlab)));

TEST(PeriodicBox, HasNoSurfaceIfALatticeFillsIt) {
  for (const Method method : {Method::sph, Method::anisotropic}) {
    for (const bool cap : {false, true}) {
      std::vector<glm::dvec3> positions;
      for (int n = 0; n < 12 * 12 * 12; ++n) {
        positions.push_back(kCube.origin + 0.5 * glm::dvec3(n % 12, n / 12 % 12, n / 144));
      }
      const ParticleField made = field_of(in_box(positions, kCube), box_options(method));
      const mesh::Mesh mesh = surface_in(made, method, cap);
      if (!cap) {
        EXPECT_TRUE(mesh.triangles.empty()) << word_of(method);
      } else {
        EXPECT_NEAR(mesh::measure_size(mesh).volume, 216, 1e-4);
        EXPECT_NEAR(mesh::measure_size(mesh).area, 216, 1e-4);
      }
    }
  }
}

TEST(PeriodicBox, GivesTheSameSurfaceOfUnlikeRadiiAcrossFaces) {
  for (const SimulationBox& box : {kCube, kSheared, kSlab}) {
    FieldOptions options;
    const auto ball = [&](const field::Affine& map, const glm::dvec3& steps) {
      ParticleSet set = in_box(ball_in(box, map, steps), box);
      ParticleAttribute radii{"radius", 1, Buffer<float>(set.size())};
      for (std::size_t i = 0; i < set.size(); ++i) {
        radii.values[i] = static_cast<float>(kBoxRadius * (i % 5 == 0 ? 1.6 : i % 2 == 0 ? 0.8 : 1));
      }
      set.attributes.push_back(std::move(radii));
      return field_of(set, options);
    };
    const ParticleField inside = ball({}, glm::dvec3(0));
    EXPECT_EQ(inside.figures.radius_attribute, "radius");
    const mesh::Mesh whole = surface_in(inside, Method::sph);
    ASSERT_GT(whole.triangles.size(), 500U);
    glm::dvec3 steps(0);
    for (int k = 0; k < 3; ++k) {
      if (box.periodic[static_cast<std::size_t>(k)]) steps[k] = std::round(inside.region->max[k] / 2.0);
    }
    const ParticleField across = ball(inside.field.index_to_world, steps);
    const mesh::Mesh open = surface_in(across, Method::sph);
    EXPECT_EQ(open.triangles.size(), whole.triangles.size());
    EXPECT_NEAR(mesh::measure_size(open).area, mesh::measure_size(whole).area, 1e-5 * mesh::measure_size(whole).area);
    EXPECT_NEAR(mesh::measure_size(surface_in(across, Method::sph, true)).volume, mesh::measure_size(whole).volume,
                1e-5 * mesh::measure_size(whole).volume);
  }
}

// Sums over the images of each particle up to `periods` periods away, in the world.
double summed_images(const std::vector<glm::dvec3>& positions, const SimulationBox& box, const glm::dvec3& at,
                     double support, const std::function<double(std::size_t)>& weight, int periods) {
  double sum = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (int x = -periods; x <= periods; ++x) {
      for (int y = -periods; y <= periods; ++y) {
        for (int z = -periods; z <= periods; ++z) {
          const glm::dvec3 image = positions[i] + box.edges * glm::dvec3(x, y, z);
          sum += weight(i) * spline_shape(glm::length(image - at) / support);
        }
      }
    }
  }
  return sum;
}

TEST(PeriodicBox, SumsEveryImageOnce) {
  // In the small box a kernel reaches across more than one period.
  const SimulationBox small{{0.3, 0.1, -5}, glm::dmat3(0.9, 0, 0, 0.2, 0.8, 0, 0.1, -0.3, 0.7), {true, true, true}};
  for (const SimulationBox& box : {kSheared, small}) {
    std::vector<glm::dvec3> positions;
    for (const glm::dvec3& f : random_positions(40, 1, 3)) positions.push_back(box.world_from_fractions()(f));
    positions[7] += box.edges * glm::dvec3(1, -1, 0);  // outside of the box
    const ParticleField made = field_of(in_box(positions, box), box_options(Method::sph));
    const double support = made.figures.support;
    const int periods = 3;
    std::vector<double> weights;
    for (const glm::dvec3& p : positions) {
      weights.push_back(1 / summed_images(
                                positions, box, p, support, [](std::size_t) { return 1.0; }, periods));
    }
    const field::IndexBox region = *made.region;
    std::size_t compared = 0;
    for_each_sample(made, [&](const glm::ivec3& index, float value) {
      if (glm::any(glm::lessThan(index, region.min - 3)) || glm::any(glm::greaterThan(index, region.max + 3))) return;
      if (++compared % 97 != 0) return;
      const glm::dvec3 at = made.field.index_to_world(glm::dvec3(index));
      const double expected = summed_images(
          positions, box, at, support, [&](std::size_t i) { return weights[i]; }, periods);
      ASSERT_NEAR(static_cast<double>(value), expected, 2e-5) << index.x << " " << index.y << " " << index.z;
    });
    EXPECT_GT(compared, 1000U);
  }
}

TEST(PeriodicBox, DepositsEachWeightOnce) {
  const std::vector<glm::dvec3> positions = random_positions(500, 30, 4);
  for (const Deposit deposit : {Deposit::nearest, Deposit::trilinear}) {
    FieldOptions options = box_options(Method::weight);
    options.deposit = deposit;
    options.weight = 1;
    const ParticleField made = field_of(in_box(positions, kSheared), options);
    double sum = 0;
    for_each_sample(made, [&](const glm::ivec3& index, float value) {
      const bool first = glm::all(glm::greaterThanEqual(index, glm::ivec3(0)));
      if (first && glm::all(glm::lessThan(index, made.region->max))) sum += static_cast<double>(value);
    });
    EXPECT_NEAR(sum, 500, 1e-3);
  }
}

TEST(PeriodicBox, GivesTheSameSurfaceWithTilesAndCountsNoImages) {
  const std::vector<glm::dvec3> positions = random_positions(20000, 6, 4);
  const ParticleSet set = in_box(positions, {glm::dvec3(0), glm::dmat3(6), {true, true, true}});
  FieldOptions options = box_options(Method::sph);
  const ParticleField all = field_of(set, options);
  options.tile_iso = 0.6;
  const ParticleField tiled = field_of(set, options);
  EXPECT_GT(tiled.figures.inside_tiles, 0U);
  EXPECT_EQ(tiled.figures.particles, 20000U);
  EXPECT_LE(tiled.figures.particles_deep_inside, 20000U);
  const mesh::Mesh a = surface_in(all, Method::sph);
  const mesh::Mesh b = surface_in(tiled, Method::sph);
  EXPECT_EQ(a.triangles.size(), b.triangles.size());
}

TEST(PeriodicBox, RejectsExtremeBoxesParticlesAndRadii) {
  const std::vector<glm::dvec3> one{{0.1, 0.2, 0.3}};
  const auto error_of = [&](const SimulationBox& box, const std::vector<glm::dvec3>& positions, double radius) {
    FieldOptions options = box_options(Method::sph);
    options.radius = radius;
    const auto made = make_field(in_box(positions, box), options, Context());
    return made ? std::string() : made.error().message;
  };
  const SimulationBox unit{glm::dvec3(0), glm::dmat3(1), {true, true, true}};
  EXPECT_EQ(error_of(unit, one, 0.25), "");
  EXPECT_EQ(error_of(unit, {{1e300, -1e300, 1e17}}, 0.25), "");
  SimulationBox huge = unit;
  huge.edges[0] *= 1e30;
  EXPECT_NE(error_of(huge, one, 0.25).find("an edge of the periodic box is 1e+30 long"), std::string::npos);
  SimulationBox far = unit;
  far.origin = glm::dvec3(1e18);
  EXPECT_NE(error_of(far, one, 0.25).find("double precision"), std::string::npos);
  SimulationBox open = unit;
  open.periodic = {true, true, false};
  EXPECT_NE(error_of(open, {{0, 0, 1e30}}, 0.25).find("a particle at (0, 0, 1e+30)"), std::string::npos);
  // One kernel reaches across the box 4e6 times along each edge.
  EXPECT_NE(error_of(unit, one, 1e6).find("periodic images"), std::string::npos);
}

TEST(PeriodicBox, ContinuesAttributesAcrossFaces) {
  for (const SimulationBox& box : {kCube, kSheared}) {
    // Two particles near opposite faces: their distance across the face is a fiftieth of the edge.
    ParticleSet set =
        in_box({box.world_from_fractions()({0.01, 0.5, 0.5}), box.world_from_fractions()({0.99, 0.5, 0.5})}, box);
    set.attributes.push_back({"T", 1, Buffer<float>(2)});
    set.attributes[0].values[0] = 1;
    set.attributes[0].values[1] = 3;
    const std::vector<glm::dvec3> vertices{box.world_from_fractions()({0, 0.5, 0.5}),
                                           box.world_from_fractions()({1, 0.5, 0.5}),
                                           box.world_from_fractions()({0.5, 0.98, 0.5})};
    const std::vector<std::size_t> which{0};
    const auto sampled = sample_attributes(set, which, vertices, kBoxRadius, 2, Context());
    ASSERT_TRUE(sampled) << sampled.error().message;
    EXPECT_NEAR(static_cast<double>(sampled->attributes[0].values[0]), 2, 1e-4);
    EXPECT_NEAR(static_cast<double>(sampled->attributes[0].values[1]), 2, 1e-4);
    EXPECT_EQ(sampled->vertices_beyond_kernels, 1U);
  }
}

}  // namespace
}  // namespace isoextract::points

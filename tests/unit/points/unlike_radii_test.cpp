// Tests fields of particles whose radii come from an attribute.
#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

ParticleSet with_radii(const std::vector<glm::dvec3>& positions, const std::vector<float>& radii) {
  ParticleSet set = particles_at(positions);
  ParticleAttribute attribute{"pscale", 1, Buffer<float>(radii.size())};
  std::ranges::copy(radii, attribute.values.begin());
  set.attributes.push_back(std::move(attribute));
  return set;
}

// The cubic spline with its normalization; h is the support.
double kernel(double r, double h) {
  const double q = r / h;
  const double shape = q < 0.5 ? 1 - 6 * q * q + 6 * q * q * q : q < 1 ? 2 * std::pow(1 - q, 3) : 0;
  return 8 / (std::numbers::pi * h * h * h) * shape;
}

std::vector<float> random_radii(std::size_t count) {
  std::vector<float> radii;
  for (const glm::dvec3& p : random_positions(count, 1, 8)) radii.push_back(static_cast<float>(0.02 + 0.03 * p.x));
  return radii;
}

TEST(UnlikeRadii, MatchTheEquations) {
  const std::vector<glm::dvec3> positions = random_positions(80, 0.3, 7);
  const std::vector<float> radii = random_radii(positions.size());
  const auto mass = [&](std::size_t j) { return std::pow(static_cast<double>(radii[j]), 3); };
  const auto support = [&](std::size_t j) { return 4 * static_cast<double>(radii[j]); };
  std::vector<double> densities(positions.size(), 0);
  for (std::size_t j = 0; j < positions.size(); ++j) {
    for (std::size_t k = 0; k < positions.size(); ++k) {
      densities[j] += mass(k) * kernel(glm::distance(positions[j], positions[k]), support(k));
    }
  }
  const ParticleField made = field_of(with_radii(positions, radii), {});
  EXPECT_EQ(made.figures.radius_attribute, "pscale");
  EXPECT_FALSE(made.figures.radius_suggested);
  std::size_t inside = 0;
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    const glm::dvec3 x = made.field.index_to_world(glm::dvec3(at));
    double truth = 0;
    for (std::size_t j = 0; j < positions.size(); ++j) {
      truth += mass(j) / densities[j] * kernel(glm::distance(x, positions[j]), support(j));
    }
    EXPECT_NEAR(static_cast<double>(value), truth, 1e-5 * (1 + truth));
    inside += static_cast<std::size_t>(truth > 0.6);
  });
  EXPECT_GT(inside, 100U);
}

TEST(UnlikeRadii, GiveTheSameBitsAsOneRadiusIfEqual) {
  const std::vector<glm::dvec3> positions = lattice_ball(0.025, 0.15, 0.3);
  for (const Method method : {Method::sph, Method::anisotropic, Method::weight}) {
    FieldOptions options;
    options.method = method;
    const ParticleField own = field_of(with_radii(positions, std::vector<float>(positions.size(), 0.03F)), options);
    options.radius = static_cast<double>(0.03F);
    const ParticleField given = field_of(particles_at(positions), options);
    EXPECT_TRUE(same_samples(samples_of(own), samples_of(given)));
    EXPECT_EQ(own.figures.radius_attribute, "pscale");
    // Given radii come first.
    EXPECT_TRUE(
        same_samples(samples_of(field_of(with_radii(positions, std::vector<float>(positions.size(), 0.07F)), options)),
                     samples_of(given)));
  }
}

TEST(UnlikeRadii, GiveOtherMethodsTheMedian) {
  const std::vector<glm::dvec3> positions = random_positions(301, 0.3, 7);
  const std::vector<float> radii = random_radii(positions.size());
  std::vector<float> sorted = radii;
  std::ranges::sort(sorted);
  for (const Method method : {Method::anisotropic, Method::weight}) {
    FieldOptions options;
    options.method = method;
    const ParticleField own = field_of(with_radii(positions, radii), options);
    options.radius = static_cast<double>(sorted[150]);
    EXPECT_TRUE(same_samples(samples_of(own), samples_of(field_of(particles_at(positions), options))));
  }
}

// Two lattices fill a box of 8 x 4 x 4: with a spacing of 1/2 below x = 4, of 1/4 above.
struct TwoLattices {
  std::vector<glm::dvec3> positions;
  std::vector<float> radii;
};

TwoLattices two_lattices() {
  TwoLattices made;
  for (const double spacing : {0.5, 0.25}) {
    const int count = static_cast<int>(4 / spacing);
    for (int i = 0; i < count * count * count; ++i) {
      const glm::dvec3 cell(i / count / count, i / count % count, i % count);
      made.positions.push_back(spacing * (cell + 0.5) + glm::dvec3(spacing < 0.5 ? 4 : 0, 0, 0));
      made.radii.push_back(static_cast<float>(spacing / 2));
    }
  }
  return made;
}

TEST(UnlikeRadii, GiveValueOneInTwoAdjacentLattices) {
  const TwoLattices two = two_lattices();
  const ParticleField made = field_of(with_radii(two.positions, two.radii), {});
  std::size_t samples = 0;
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    const glm::dvec3 p = made.field.index_to_world(glm::dvec3(at));
    if (glm::any(glm::lessThan(p, glm::dvec3(1.2))) || glm::any(glm::greaterThan(p, glm::dvec3(6.8, 2.8, 2.8)))) return;
    ++samples;
    EXPECT_NEAR(value, 1, std::abs(p.x - 4) < 1 ? 0.12 : 0.01) << p.x << " " << p.y << " " << p.z;
  });
  EXPECT_GT(samples, 1000U);
}

TEST(UnlikeRadii, KeepTheSamplesNearTheSurfaceWithTiles) {
  const TwoLattices two = two_lattices();
  const ParticleField whole = field_of(with_radii(two.positions, two.radii), {});
  FieldOptions options;
  options.tile_iso = 0.6;
  const ParticleField tiled = field_of(with_radii(two.positions, two.radii), options);
  EXPECT_GT(tiled.figures.inside_tiles, 0U);
  std::size_t kept = 0;
  for (const field::SparseBlock& block : samples_of(tiled).blocks) {
    const auto same = std::ranges::find(samples_of(whole).blocks, block.origin, &field::SparseBlock::origin);
    ASSERT_NE(same, samples_of(whole).blocks.end());
    EXPECT_EQ(std::memcmp(block.values, same->values, 512 * sizeof(float)), 0);
    ++kept;
  }
  EXPECT_EQ(kept + tiled.figures.inside_tiles, samples_of(whole).blocks.size());
}

TEST(UnlikeRadii, AreTheSameForAnyNumberOfThreads) {
  const TwoLattices two = two_lattices();
  const ParticleField many = field_of(with_radii(two.positions, two.radii), {});
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(same_samples(samples_of(field_of(with_radii(two.positions, two.radii), {})), samples_of(many)));
}

TEST(UnlikeRadii, ExcludeParticlesThatAreTooSmall) {
  const std::vector<glm::dvec3> positions{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0.5, 0, 0}, {1.5, 0, 0}};
  const ParticleField made = field_of(with_radii(positions, {0.5F, 0.6F, 0.5F, 0, 0.05F}), {});
  EXPECT_EQ(made.figures.particles, 3U);
  EXPECT_EQ(made.figures.particles_too_small, 2U);
  EXPECT_DOUBLE_EQ(made.figures.least_radius, 0.25);
  const ParticleField without =
      field_of(with_radii({positions.begin(), positions.begin() + 3}, {0.5F, 0.6F, 0.5F}), {});
  EXPECT_TRUE(same_samples(samples_of(made), samples_of(without)));
}

TEST(UnlikeRadii, AreRefusedIfInvalidOrFarTooLarge) {
  const std::vector<glm::dvec3> positions = random_positions(100, 1, 7);
  for (const float bad : {-1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<float> radii(100, 0.1F);
    radii[7] = bad;
    const auto refused = make_field(with_radii(positions, radii), {}, Context());
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("at particle 7"), std::string::npos) << refused.error().message;
  }
  const std::vector<glm::dvec3> many = random_positions(70000, 10, 7);
  std::vector<float> radii(many.size(), 0.1F);
  radii[3] = 1000;
  const auto refused = make_field(with_radii(many, radii), {}, Context());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("hold too many of the"), std::string::npos) << refused.error().message;
}

}  // namespace
}  // namespace isoextract::points

#include "points/particle_statistics.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

ParticleStatistics statistics_of(const std::vector<glm::dvec3>& positions) {
  auto measured = measure_statistics(particles_at(positions), Context());
  EXPECT_TRUE(measured);
  return *measured;
}

TEST(ParticleStatistics, MeasureBoundsAndDistances) {
  std::vector<glm::dvec3> positions = lattice_ball(0.5, 4);
  const std::size_t count = positions.size();
  positions.emplace_back(1e6, 0, 0);
  positions.emplace_back(0, std::numeric_limits<double>::quiet_NaN(), 0);
  positions.push_back(positions[0]);  // coincides with the first
  const ParticleStatistics s = statistics_of(positions);
  EXPECT_EQ(s.bounds.finite, count + 2);
  EXPECT_EQ(s.bounds.not_finite, 1U);
  EXPECT_EQ(s.bounds.first_broken, count + 1);
  EXPECT_EQ(s.bounds.box, (field::Box{{-4, -4, -4}, {1e6, 4, 4}}));
  ASSERT_TRUE(s.neighbors);
  EXPECT_EQ(s.neighbors->asked, count + 2);
  EXPECT_EQ(s.neighbors->min, 1) << "none is its own neighbour, nor what is at its place";
  EXPECT_EQ(s.neighbors->median, 1);
  EXPECT_EQ(s.neighbors->max, 1e6 - 4);
  EXPECT_NEAR(s.suggested_radius.value(), 0.5, 0.02);
}

std::vector<glm::dvec3> box_of(int x, int y, int z) {
  std::vector<glm::dvec3> positions;
  for (int i = 0; i < x; ++i) {
    for (int j = 0; j < y; ++j) {
      for (int k = 0; k < z; ++k) positions.emplace_back(i, j, k);
    }
  }
  return positions;
}

std::vector<glm::dvec3> operator+(std::vector<glm::dvec3> a, const std::vector<glm::dvec3>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<glm::dvec3> moved(std::vector<glm::dvec3> positions, const glm::dvec3& by, double scale = 1) {
  for (glm::dvec3& p : positions) p = scale * (p + by);
  return positions;
}

double radius_of(const std::vector<glm::dvec3>& positions) {
  return statistics_of(positions).suggested_radius.value_or(0);
}

TEST(SuggestedRadius, IsHalfTheSpacingAtUnitDensity) {
  const std::vector<glm::dvec3> cube = box_of(12, 12, 12);
  const std::vector<glm::dvec3> face_centered =
      moved(cube + moved(cube, {.5, .5, 0}) + moved(cube, {.5, 0, .5}) + moved(cube, {0, .5, .5}), {}, std::cbrt(4.0));
  const std::vector<glm::dvec3> body_centered = moved(cube + moved(cube, glm::dvec3(.5)), {}, std::cbrt(2.0));
  const std::vector<glm::dvec3> random = random_positions(8000, 20, 1);
  std::vector<glm::dvec3> eight_a_cell;  // as FLIP places them
  const std::vector<glm::dvec3> offsets = random_positions(8000, 2, 2);
  for (std::size_t n = 0; n < offsets.size(); ++n) {
    const int cell = static_cast<int>(n) / 8;
    eight_a_cell.push_back(offsets[n] + 2.0 * glm::dvec3(cell / 100, cell / 10 % 10, cell % 10));
  }
  std::vector<glm::dvec3> jittered = lattice_ball(0.5, 10, 0.8);
  for (const std::vector<glm::dvec3>& positions :
       {cube, face_centered, body_centered, random, eight_a_cell, jittered, box_of(40, 40, 1), box_of(40, 40, 2),
        box_of(500, 1, 1), box_of(200, 2, 2), cube + cube, cube + std::vector<glm::dvec3>{{1e8, 0, 0}},
        cube + moved(cube, glm::dvec3(100), 2), lattice_ball(0.5, 26)}) {
    EXPECT_NEAR(radius_of(positions), 0.5, 0.02) << positions.size() << " particles";
  }
}

TEST(SuggestedRadius, IsExactForFewParticlesOnALattice) {
  for (const glm::ivec3& size :
       {glm::ivec3(2, 1, 1), {3, 1, 1}, {2, 2, 1}, {2, 2, 2}, {3, 3, 1}, {3, 2, 2}, {40, 1, 1}, {5, 4, 2}, {4, 4, 3}}) {
    EXPECT_NEAR(radius_of(box_of(size.x, size.y, size.z)), 0.5, 1e-9) << size.x << size.y << size.z;
  }
  EXPECT_NEAR(radius_of({{1e-200, 0, 0}, {0, 0, 0}}), 0, 1e-200);
  EXPECT_NEAR(radius_of({{0, 0, 0}, {1, 0, 0}, {.5, std::sqrt(.75), 0}}), 0.5, 1e-9) << "a triangle";
}

TEST(SuggestedRadius, IsTheSameForUnitsAndOrders) {
  const std::vector<glm::dvec3> positions = random_positions(3000, 14, 3);
  EXPECT_NEAR(radius_of(moved(positions, {}, 1e-3)) / radius_of(positions), 1e-3, 1e-12);
  std::vector<glm::dvec3> reversed(positions.rbegin(), positions.rend());
  EXPECT_NEAR(radius_of(reversed), radius_of(positions), 1e-12);
}

TEST(ParticleStatistics, HaveNoDistanceForOneParticle) {
  EXPECT_EQ(statistics_of({}).bounds.finite, 0U);
  EXPECT_FALSE(statistics_of({}).neighbors);
  EXPECT_FALSE(statistics_of({{1, 2, 3}}).suggested_radius);
  EXPECT_FALSE(statistics_of(std::vector<glm::dvec3>(100000, {1, 2, 3})).neighbors);
}

TEST(ParticleStatistics, SampleLargeSets) {
  const std::vector<glm::dvec3> positions = lattice_ball(0.5, 26);
  ASSERT_GT(positions.size(), std::size_t{1} << 16U);
  const ParticleStatistics s = statistics_of(positions);
  EXPECT_EQ(s.neighbors->asked, std::size_t{1} << 16U);
  EXPECT_EQ(s.neighbors->max, 1);
}

}  // namespace
}  // namespace isoextract::points

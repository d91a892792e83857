#include "points/particle_statistics.hpp"

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
  EXPECT_EQ(s.suggested_radius(), 0.5);
}

TEST(ParticleStatistics, HaveNoDistanceForOneParticle) {
  EXPECT_EQ(statistics_of({}).bounds.finite, 0U);
  EXPECT_FALSE(statistics_of({}).neighbors);
  EXPECT_FALSE(statistics_of({{1, 2, 3}}).suggested_radius());
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

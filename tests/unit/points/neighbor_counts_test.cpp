#include "points/neighbor_counts.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

Buffer<float> counts_of(ParticleSet& set, double radius, double smoothing_length) {
  const auto index = add_neighbor_counts(set, radius, smoothing_length, Context());
  if (!index) {
    ADD_FAILURE() << index.error().message;
    return {};
  }
  return std::move(set.attributes[*index].values);
}

TEST(NeighborCounts, EqualTheSumOverAllPairs) {
  std::vector<glm::dvec3> positions = random_positions(300, 1, 43);
  positions.push_back(positions[5]);
  positions.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  positions.emplace_back(50, 0, 0);
  ParticleSet set = particles_at(positions);
  const Buffer<float> counts = counts_of(set, 0.05, 2);
  ASSERT_EQ(counts.size(), positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) {
    double expected = 0;
    for (std::size_t j = 0; j < positions.size(); ++j) {
      const double distance = glm::length(positions[i] - positions[j]);
      if (i != j && distance < 0.2) expected += 1 - std::pow(distance / 0.2, 2);
    }
    EXPECT_NEAR(counts[i], expected, 1e-5) << i;
  }
}

TEST(NeighborCounts, DistinguishBulkFromDroplets) {
  ParticleSet set = particles_at(lattice(1, 4, [](const glm::dvec3&) { return true; }));
  const Buffer<float> counts = counts_of(set, 1, 2);
  // Of a lattice 2 apart within 4: 6 at a quarter, 12 at a half and 8 at three quarters of the squared support.
  EXPECT_NEAR(counts[counts.size() / 2], 6 * 0.75 + 12 * 0.5 + 8 * 0.25, 1e-5);
  EXPECT_GT(smoothing_weight(12.5), 0.99);
  ParticleSet pair = particles_at({{0, 0, 0}, {2, 0, 0}});
  EXPECT_LT(smoothing_weight(counts_of(pair, 1, 2)[0]), 0.01);
  EXPECT_EQ(smoothing_weight(0), 0);
  EXPECT_EQ(smoothing_weight(13), 1);
  EXPECT_EQ(smoothing_weight(100), 1);
  EXPECT_NEAR(smoothing_weight(6.5), 0.5, 1e-12);
}

TEST(NeighborCounts, ContinueAcrossTheFacesOfAPeriodicBox) {
  ParticleSet set = particles_at({{1, 5, 5}, {9, 5, 5}, {5, 5, 5}});
  set.box = SimulationBox{
      glm::dvec3(0), {glm::dvec3(10, 0, 0), glm::dvec3(0, 10, 0), glm::dvec3(0, 0, 10)}, {true, true, true}};
  const Buffer<float> counts = counts_of(set, 1, 2);
  EXPECT_NEAR(counts[0], 0.75, 1e-5);
  EXPECT_NEAR(counts[1], 0.75, 1e-5);
  EXPECT_NEAR(counts[2], 0, 1e-5);
}

TEST(NeighborCounts, AreTheSameForAnyNumberOfThreads) {
  std::vector<Buffer<float>> made;
  for (const std::size_t threads : {1U, 3U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    ParticleSet set = particles_at(random_positions(5000, 1, 44));
    made.push_back(counts_of(set, 0.03, 2));
  }
  EXPECT_TRUE(std::ranges::equal(made[0], made[1]));
}

}  // namespace
}  // namespace isoextract::points

// Tests neighbors, distances and the default radius of particles in periodic boxes.
#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "points/detail/nearby_positions.hpp"
#include "points/particle_statistics.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

SimulationBox box_of(const glm::dmat3& edges, const std::array<bool, 3>& periodic = {true, true, true}) {
  return {{-3, 1, 2}, edges, periodic};
}

glm::dmat3 upright(double x, double y, double z) { return {x, 0, 0, 0, y, 0, 0, 0, z}; }

ParticleSet set_in(const std::vector<glm::dvec3>& positions, const SimulationBox& box) {
  ParticleSet set = particles_at(positions);
  set.box = box;
  return set;
}

// Returns the vectors to the nearest of all images up to 5 periods away, in order of distance.
std::vector<glm::dvec3> nearest_images(const ParticleSet& set, std::size_t particle, std::size_t count) {
  std::vector<glm::dvec3> offsets;
  constexpr int kPeriods = 5;
  for (int n = 0; n < (2 * kPeriods + 1) * (2 * kPeriods + 1) * (2 * kPeriods + 1); ++n) {
    const glm::ivec3 periods = glm::ivec3(n % 11, n / 11 % 11, n / 121) - kPeriods;
    bool is_image = true;
    for (int k = 0; k < 3; ++k)
      is_image = is_image && (set.box->periodic[static_cast<std::size_t>(k)] || periods[k] == 0);
    if (!is_image) continue;
    for (const glm::dvec3& p : set.positions) {
      const glm::dvec3 offset = p + set.box->edges * glm::dvec3(periods) - set.positions[particle];
      if (glm::length(offset) > 1e-6) offsets.push_back(offset);
    }
  }
  std::ranges::sort(offsets, {}, [](const glm::dvec3& o) { return glm::length(o); });
  offsets.resize(std::min(count, offsets.size()));
  return offsets;
}

TEST(NearbyPositions, AreTheNearestOfAllImages) {
  const SimulationBox boxes[] = {box_of(upright(2, 3, 2.5)), box_of(upright(2, 3, 0.4)),
                                 box_of({2, 0, 0, 1.2, 2, 0, -0.7, 0.9, 1.5}),
                                 box_of(upright(2, 3, 2.5), {true, false, false}),
                                 box_of({2, 0, 0, 1.2, 2, 0, -0.7, 0.9, 1.5}, {false, true, true})};
  for (const SimulationBox& box : boxes) {
    std::vector<glm::dvec3> fractions = random_positions(60, 1, 11);
    for (glm::dvec3& f : fractions) f = box.world_from_fractions()(f);
    const ParticleSet set = set_in(fractions, box);
    const auto nearby = NearbyPositions::make(set, Context());
    ASSERT_TRUE(nearby);
    for (std::size_t i = 0; i < set.size(); ++i) {
      std::vector<glm::dvec3> found;
      nearby->find(i, 48, found);
      const auto expected = nearest_images(set, i, 48);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t n = 0; n < found.size(); ++n) {
        // Images at opposite sides can be equally near.
        EXPECT_NEAR(glm::length(found[n]), glm::length(expected[n]), 1e-12) << i << " " << n;
      }
    }
  }
}

TEST(NearbyPositions, CountImagesOnOppositeFacesOnce) {
  // The first two are one position of the periodic lattice, apart from rounding, and so are the last two.
  const ParticleSet set =
      set_in({{-3, 1, 2}, {-1 - 1e-12, 1, 2}, {-2, 1, 2}, {-2, 4 - 1e-12, 2}}, box_of(upright(2, 3, 2.5)));
  const auto nearby = NearbyPositions::make(set, Context());
  std::vector<glm::dvec3> found;
  nearby->find(0, 6, found);
  ASSERT_EQ(found.size(), 6U);
  const std::array<double, 5> distances{1, 1, 2, 2, 2.5};
  for (std::size_t n = 0; n < distances.size(); ++n) EXPECT_NEAR(glm::length(found[n]), distances[n], 1e-9) << n;
}

double radius_of(const ParticleSet& set) { return suggest_radius(set, Context()).value_or(std::nullopt).value_or(0); }

// Lattices of any size have the radius of an endless one; without the box, small ones have no particle inside.
TEST(SuggestedRadius, IsIndependentOfTheSizeOfAPeriodicLattice) {
  for (const int cells : {1, 2, 3, 5, 12}) {
    std::vector<glm::dvec3> positions;
    for (int n = 0; n < cells * cells * cells; ++n) {
      positions.push_back(glm::dvec3(-3, 1, 2) + 0.5 * glm::dvec3(n % cells, n / cells % cells, n / cells / cells));
    }
    const double side = 0.5 * cells;
    EXPECT_NEAR(radius_of(set_in(positions, box_of(upright(side, side, side)))), 0.2575, 0.002) << cells;
  }
}

TEST(SuggestedRadius, DoesNotChangeIfAllParticlesMove) {
  const SimulationBox box = box_of({2, 0, 0, 0.5, 2, 0, -0.3, 0.4, 2});
  std::vector<glm::dvec3> positions = random_positions(300, 1, 5);
  for (glm::dvec3& p : positions) p = box.world_from_fractions()(p * glm::dvec3(0.4, 1, 1));  // a slab
  const double radius = radius_of(set_in(positions, box));
  EXPECT_NEAR(radius, 0.5 * std::cbrt(0.4 * 8 / 300), 0.01);
  for (glm::dvec3& p : positions) p += box.edges * glm::dvec3(0.8, 7.5, -0.3);  // the slab lies across a face
  EXPECT_NEAR(radius_of(set_in(positions, box)), radius, 1e-9);
}

TEST(ParticleStatistics, HaveDistancesAcrossFaces) {
  const ParticleSet set = set_in({{-2.9, 1, 2}, {-1.1, 1, 2}}, box_of(upright(2, 30, 30)));
  const auto statistics = measure_statistics(set, Context());
  ASSERT_TRUE(statistics);
  EXPECT_NEAR(statistics->neighbors->max, 0.2, 1e-12);
}

}  // namespace
}  // namespace isoextract::points

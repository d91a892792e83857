// Summed weights (seed paper on marching tetrahedra in shaders).
#include <map>
#include <tuple>

#include <gtest/gtest.h>

#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

using Sample = std::tuple<int, int, int>;

TEST(Weights, AddToTheNearestSample) {
  const std::vector<glm::dvec3> positions = random_positions(200, 9, 31);
  FieldOptions options;
  options.method = Method::weight;
  options.deposit = Deposit::nearest;
  options.radius = 1;
  options.spacing = 1;
  const ParticleField made = field_of(particles_at(positions), options);
  std::map<Sample, int> counts;
  for (const glm::dvec3& p : positions) {
    const glm::dvec3 at = glm::floor(made.field.index_to_world.inverse()(p) + 0.5);
    ++counts[{static_cast<int>(at.x), static_cast<int>(at.y), static_cast<int>(at.z)}];
  }
  std::size_t samples = 0;
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    const auto count = counts.find({at.x, at.y, at.z});
    EXPECT_EQ(value, static_cast<float>(0.1 * (count == counts.end() ? 0 : count->second)));
    samples += static_cast<std::size_t>(count != counts.end());
  });
  EXPECT_EQ(samples, counts.size()) << "every weight is in a stored brick";
}

TEST(Weights, SpreadOverEightSamples) {
  std::vector<glm::dvec3> positions = random_positions(300, 20, 32);
  positions.insert(positions.end(), {{0, 0, 0}, {8, 8, 8}, {7.5, 8, 15.5}});  // on samples, and on the boundary between
                                                                              // bricks
  FieldOptions options;
  options.method = Method::weight;
  options.weight = 0.25;
  options.radius = 1;
  options.spacing = 1;
  const ParticleField made = field_of(particles_at(positions), options);
  double total = 0;
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    double expected = 0;
    for (const glm::dvec3& p : positions) {
      const glm::dvec3 share =
          glm::max(glm::dvec3(0), 1.0 - glm::abs(made.field.index_to_world.inverse()(p) - glm::dvec3(at)));
      expected += 0.25 * share.x * share.y * share.z;
    }
    EXPECT_NEAR(static_cast<double>(value), expected, 1e-7);
    total += static_cast<double>(value);
  });
  EXPECT_NEAR(total, 0.25 * static_cast<double>(positions.size()), 1e-4) << "none is lost";
}

TEST(Weights, NeedTwoParticlesForAnInsideSample) {
  FieldOptions options;
  options.method = Method::weight;
  options.deposit = Deposit::nearest;
  options.radius = 0.25;
  const double iso = method_info(Method::weight).iso;
  const auto greatest = [&](const std::vector<glm::dvec3>& positions) {
    float most = 0;
    for_each_sample(field_of(particles_at(positions), options),
                    [&](const glm::ivec3&, float value) { most = std::max(most, value); });
    return static_cast<double>(most);
  };
  EXPECT_LT(greatest({{0.1, 0, 0}}), iso);
  EXPECT_GT(greatest({{0.1, 0, 0}, {-0.1, 0, 0}}), iso);
  // With the default spacing, all samples in a liquid are inside.
  const std::vector<glm::dvec3> liquid =
      lattice(0.25, 9, [](const glm::dvec3& p) { return glm::all(glm::lessThan(glm::abs(p), glm::dvec3(4.2))); });
  for (const Deposit deposit : {Deposit::nearest, Deposit::trilinear}) {
    options.deposit = deposit;
    const ParticleField made = field_of(particles_at(liquid), options);
    EXPECT_EQ(made.figures.spacing, 1);
    for_each_sample(made, [&](const glm::ivec3& at, float value) {
      const glm::dvec3 p = glm::abs(made.field.index_to_world(glm::dvec3(at)));
      if (glm::any(glm::greaterThan(p, glm::dvec3(3)))) return;
      EXPECT_NEAR(static_cast<double>(value), 0.8, 1e-6);
    });
  }
}

}  // namespace
}  // namespace isoextract::points

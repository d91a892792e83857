#include "points/attribute_sampling.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "base/parallel.hpp"
#include "points/detail/cubic_spline.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kSamplingRadius = 0.05;

// Adds two attributes: "one" is 1, "place" the position.
ParticleSet with_attributes(const std::vector<glm::dvec3>& positions) {
  ParticleSet set = particles_at(positions);
  set.attributes.push_back({"one", 1, Buffer<float>(positions.size())});
  set.attributes.push_back({"place", 3, Buffer<float>(3 * positions.size())});
  for (std::size_t i = 0; i < positions.size(); ++i) {
    set.attributes[0].values[i] = 1;
    for (int axis = 0; axis < 3; ++axis) {
      set.attributes[1].values[3 * i + static_cast<std::size_t>(axis)] = static_cast<float>(positions[i][axis]);
    }
  }
  return set;
}

SampledAttributes sampled(const ParticleSet& set, const std::vector<std::size_t>& which,
                          const std::vector<glm::dvec3>& vertices) {
  auto result = sample_attributes(set, which, vertices, kSamplingRadius, 2, Context());
  if (!result) {
    ADD_FAILURE() << result.error().message;
    return {};
  }
  return std::move(*result);
}

TEST(AttributeSampling, EqualsTheWeightedMean) {
  std::vector<glm::dvec3> positions = random_positions(200, 0.7, 41);
  positions.push_back(positions[5]);
  const ParticleSet set = with_attributes(positions);
  const std::vector<glm::dvec3> vertices = random_positions(50, 0.7, 42);
  const SampledAttributes result = sampled(set, {1, 0}, vertices);
  ASSERT_EQ(result.attributes.size(), 2U);
  EXPECT_EQ(result.attributes[0].name, "place");
  EXPECT_EQ(result.attributes[0].components, 3U);
  EXPECT_EQ(result.vertices_beyond_kernels, 0U);
  const double support = 4 * kSamplingRadius;
  const auto kernel = [&](double distance) { return spline_shape(distance / support); };
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    double total = 0;
    glm::dvec3 sum(0);
    for (const glm::dvec3& p : positions) {
      double density = 0;
      for (const glm::dvec3& q : positions) density += kernel(glm::length(p - q));
      const double w = kernel(glm::length(p - vertices[v])) / density;
      total += w;
      sum += w * p;
    }
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(static_cast<double>(result.attributes[0].values[3 * v + static_cast<std::size_t>(axis)]),
                  sum[axis] / total, 1e-6);
    }
    EXPECT_EQ(result.attributes[1].values[v], 1) << "a constant stays constant";
  }
}

TEST(AttributeSampling, ReproducesALinearFieldInTheLiquid) {
  const ParticleSet set = with_attributes(lattice_ball(kSamplingRadius, 1));
  const std::vector<glm::dvec3> vertices = random_positions(100, 0.4, 43);
  const SampledAttributes result = sampled(set, {1}, vertices);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    EXPECT_NEAR(static_cast<double>(result.attributes[0].values[3 * v]), vertices[v].x, 0.1 * kSamplingRadius);
  }
}

TEST(AttributeSampling, UsesTheNearestParticleBeyondAllKernels) {
  std::vector<glm::dvec3> positions = {{0, 0, 0}, {1, 0, 0}};
  positions.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  const ParticleSet set = with_attributes(positions);
  const SampledAttributes result = sampled(set, {1}, {{0.1, 0, 0}, {0.6, 0, 0}, {-1e300, 0, 0}});
  EXPECT_EQ(result.vertices_beyond_kernels, 2U);
  EXPECT_EQ(result.attributes[0].values[0], 0);
  EXPECT_EQ(result.attributes[0].values[3], 1);
  EXPECT_EQ(result.attributes[0].values[6], 0);
  const std::vector<glm::dvec3> vertices(1, glm::dvec3(0));
  EXPECT_FALSE(sample_attributes(particles_at({}), {}, vertices, kSamplingRadius, 2, Context()));
  EXPECT_FALSE(sample_attributes(set, {}, vertices, 0, 2, Context()));
  EXPECT_TRUE(sample_attributes(particles_at({}), {}, {}, kSamplingRadius, 2, Context()));
}

// Some vertices lie beyond the kernels of all particles.
TEST(AttributeSampling, IsTheSameForPartsOfTheVertices) {
  const ParticleSet set = with_attributes(random_positions(2000, 1, 46));
  const std::vector<glm::dvec3> vertices = random_positions(3000, 1.5, 47);
  const SampledAttributes whole = sampled(set, {1, 0}, vertices);
  EXPECT_GT(whole.vertices_beyond_kernels, 100U);
  const std::vector<std::size_t> which = {1, 0};
  const auto sampler = AttributeSampler::make(set, which, kSamplingRadius, 2, Context());
  ASSERT_TRUE(sampler);
  constexpr std::size_t kPart = 70;
  std::atomic<std::uint64_t> beyond{0};
  for_each_range(vertices.size(), kPart, [&](std::size_t begin, std::size_t end) {
    const auto part = sampler->sample(std::span(vertices).subspan(begin, end - begin), Context());
    ASSERT_TRUE(part);
    beyond += part->vertices_beyond_kernels;
    for (std::size_t a = 0; a < which.size(); ++a) {
      const std::size_t width = whole.attributes[a].components;
      const float* const wanted = whole.attributes[a].values.data() + begin * width;
      EXPECT_TRUE(std::equal(part->attributes[a].values.begin(), part->attributes[a].values.end(), wanted));
    }
  });
  EXPECT_EQ(beyond, whole.vertices_beyond_kernels);
}

TEST(AttributeSampling, IsTheSameForAnyNumberOfThreads) {
  const ParticleSet set = with_attributes(random_positions(2000, 1, 44));
  const std::vector<glm::dvec3> vertices = random_positions(3000, 1, 45);
  std::optional<SampledAttributes> first;
  for (const std::size_t threads : {1U, 2U, 5U}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    SampledAttributes result = sampled(set, {1}, vertices);
    if (!first) {
      first = std::move(result);
      continue;
    }
    EXPECT_TRUE(std::ranges::equal(first->attributes[0].values, result.attributes[0].values));
  }
}

}  // namespace
}  // namespace isoextract::points

// Tests that a field's memory is reserved, depends on the particles and not on their bounds, and is released.
#include <gtest/gtest.h>

#include "points/attribute_sampling.hpp"
#include "points/particle_statistics.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kMemoryRadius = 0.025;

class FieldMemory : public testing::TestWithParam<Method> {
 protected:
  FieldMemory() {
    options_.method = GetParam();
    options_.radius = kMemoryRadius;
    options_.tile_iso = method_info(GetParam()).iso;
    if (GetParam() == Method::weight) options_.cell_size = 1;
  }

  static std::uint64_t peak_of(const ParticleSet& particles, const FieldOptions& options) {
    const Context context(MemoryBudget(std::uint64_t{1} << 34));
    EXPECT_TRUE(make_field(particles, options, context));
    EXPECT_EQ(context.memory().reserved(), 0U);
    return context.memory().peak();
  }

  FieldOptions options_;
};

INSTANTIATE_TEST_SUITE_P(Methods, FieldMemory, testing::Values(Method::weight, Method::sph, Method::anisotropic),
                         [](const auto& method) { return std::string(word_of(method.param)); });

TEST_P(FieldMemory, CostsLittleForADistantParticle) {
  std::vector<glm::dvec3> positions = lattice_ball(kMemoryRadius, 0.6);
  const std::uint64_t without = peak_of(particles_at(positions), options_);
  positions.emplace_back(1e5 * kMemoryRadius, -1e5 * kMemoryRadius, 1e5 * kMemoryRadius);
  EXPECT_LT(static_cast<double>(peak_of(particles_at(positions), options_)), 1.1 * static_cast<double>(without));
}

TEST_P(FieldMemory, StaysReservedWhileTheFieldLives) {
  const ParticleSet particles = particles_at(lattice_ball(kMemoryRadius, 0.4));
  const Context context(MemoryBudget(std::uint64_t{1} << 34));
  {
    const auto made = make_field(particles, options_, context);
    ASSERT_TRUE(made) << made.error().message;
    const std::uint64_t blocks = samples_of(*made).blocks.size();
    EXPECT_EQ(context.memory().reserved(), blocks * (512 * sizeof(float) + sizeof(field::SparseBlock)) +
                                               samples_of(*made).tiles.size() * sizeof(field::SparseTile));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
  const std::uint64_t peak = context.memory().peak();
  EXPECT_TRUE(make_field(particles, options_, Context(MemoryBudget(peak))));
  const Context little(MemoryBudget(peak - 1));
  const auto refused = make_field(particles, options_, little);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit)) << refused.error().message;
  EXPECT_NE(refused.error().message.find("test.ply"), std::string::npos) << refused.error().message;
  EXPECT_EQ(little.memory().reserved(), 0U);
}

// Sorting holds the positions, the sorted ones and an index; the sums hold all but the positions, and the bricks.
TEST(FieldMemoryPerParticle, IsBelow64BytesWhenPositionsAreFreed) {
  FieldOptions options;
  options.radius = kMemoryRadius;
  options.tile_iso = method_info(Method::sph).iso;
  const Context context(MemoryBudget(std::uint64_t{1} << 34));
  ParticleSet particles = particles_at(lattice_ball(kMemoryRadius, 1.6, 0.4));
  const std::uint64_t count = particles.size();
  EXPECT_GT(count, 100000U);
  particles.memory = *context.reserve(particles.positions.size_bytes(), "positions");
  const auto made = make_field_and_free(particles, options, context);
  ASSERT_TRUE(made) << made.error().message;
  EXPECT_TRUE(particles.positions.empty());
  EXPECT_EQ(particles.memory.bytes(), 0U);
  const std::uint64_t bricks = context.memory().reserved();
  EXPECT_LT(context.memory().peak(), std::max(58 * count, 36 * count + bricks));
  EXPECT_GT(made->figures.particles_deep_inside, count / 3);  // also where the particles are irregular

  const ParticleSet kept = particles_at(lattice_ball(kMemoryRadius, 1.6, 0.4));
  const auto same = make_field(kept, options, Context());
  ASSERT_TRUE(same) << same.error().message;
  EXPECT_EQ(kept.size(), count);
  const field::SparseSamples& freed = samples_of(*made);
  ASSERT_EQ(samples_of(*same).blocks.size(), freed.blocks.size());
  for (std::size_t b = 0; b < freed.blocks.size(); ++b) {
    EXPECT_EQ(std::memcmp(freed.blocks[b].values, samples_of(*same).blocks[b].values, 512 * sizeof(float)), 0);
  }
}

// The list of bricks within the kernels' reach alone exceeds the memory.
TEST_P(FieldMemory, RefusesTooManySamplesBeforeWork) {
  if (GetParam() == Method::weight) GTEST_SKIP() << "its particles reach one sample far";
  const ParticleSet particles = particles_at({{0, 0, 0}, {0.05, 0, 0}});
  for (const double cell : {1e-3, 1e-5, 1e-7}) {
    options_.radius = 1;
    options_.cell_size = cell;
    const Context context(MemoryBudget(std::uint64_t{1} << 30));
    const auto refused = make_field(particles, options_, context);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit)) << refused.error().message;
    EXPECT_NE(refused.error().message.find("around each particle"), std::string::npos) << refused.error().message;
    EXPECT_LT(context.memory().peak(), std::uint64_t{1} << 16);
  }
}

TEST_P(FieldMemory, ReleasesEverythingWhenCancelled) {
  const ParticleSet particles = particles_at(lattice_ball(kMemoryRadius, 0.2));
  options_.radius.reset();
  const Context context;
  context.cancel();
  const auto refused = make_field(particles, options_, context);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::cancelled);
  EXPECT_EQ(context.memory().reserved(), 0U);
  const auto statistics = measure_statistics(particles, context);
  ASSERT_FALSE(statistics);
  EXPECT_EQ(statistics.error().code, ErrorCode::cancelled);
  const std::vector<glm::dvec3> vertices(1, glm::dvec3(0));
  const auto sampled = sample_attributes(particles, {}, vertices, kMemoryRadius, 2, context);
  ASSERT_FALSE(sampled);
  EXPECT_EQ(sampled.error().code, ErrorCode::cancelled);
  EXPECT_EQ(context.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::points

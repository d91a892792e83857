// A jet into a tank, frame by frame.
#include "simulate/particle_jet.hpp"

#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "base/finite.hpp"

namespace isoextract::simulate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

JetOptions small_jet() {
  JetOptions options;
  options.count = 1500;
  options.tank = glm::dvec3(30, 24, 36);
  options.radius = 0.5;
  options.nozzle = 3;
  return options;
}

ParticleJet jet_after(const JetOptions& options, int frames) {
  auto jet = ParticleJet::make(options, Context());
  if (!jet) throw std::runtime_error(jet.error().message);
  for (int i = 0; i < frames; ++i) {
    if (auto done = jet->advance(Context()); !done) throw std::runtime_error(done.error().message);
  }
  return std::move(*jet);
}

points::ParticleSet particles_of(const ParticleJet& jet) { return std::move(*jet.particles(Context())); }

Error refusal(const JetOptions& options) {
  const Context context;
  const auto jet = ParticleJet::make(options, context);
  if (jet) throw std::runtime_error("was not refused");
  EXPECT_EQ(jet.error().code, ErrorCode::usage);
  EXPECT_EQ(context.memory().reserved(), 0U);
  return jet.error();
}

bool same_bits(const points::ParticleSet& a, const points::ParticleSet& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t k = 0; k < a.attributes.size(); ++k) {
    const auto& values = a.attributes[k].values;
    if (std::memcmp(values.data(), b.attributes[k].values.data(), values.size_bytes()) != 0) return false;
  }
  return std::memcmp(a.positions.data(), b.positions.data(), a.positions.size_bytes()) == 0;
}

void expect_sound(const points::ParticleSet& set, const glm::dvec3& tank, double radius) {
  for (std::size_t i = 0; i < set.size(); ++i) {
    const glm::dvec3& p = set.positions[i];
    ASSERT_TRUE(is_finite(p)) << i;
    ASSERT_TRUE(glm::all(glm::lessThanEqual(glm::abs(p), tank / 2.0 - radius * (1 - 1e-12)))) << i;
    for (int axis = 0; axis < 3; ++axis) ASSERT_TRUE(std::isfinite(set.attributes[0].values[3 * i + axis])) << i;
  }
}

TEST(ParticleJet, EmitsSteadilyUntilCountIsReached) {
  const JetOptions options = small_jet();
  ParticleJet jet = jet_after(options, 0);
  EXPECT_EQ(jet.size(), 0U);
  EXPECT_EQ(jet.radius(), 0.5);
  // A circle of radius 3 contains 29 lattice points; a layer leaves every 1 / 60 s, 2.5 a frame.
  for (int frame = 1; frame <= 30; ++frame) {
    ASSERT_TRUE(jet.advance(Context()));
    const auto layers = static_cast<std::uint64_t>(frame * 2.5 + 1e-9) + 1;
    EXPECT_EQ(jet.size(), std::min<std::uint64_t>(options.count, 29 * layers)) << frame;
    expect_sound(particles_of(jet), options.tank, 0.5);
  }
  EXPECT_EQ(jet.size(), options.count);
  const JetFigures figures = jet.figures();
  EXPECT_EQ(figures.frames, 30U);
  EXPECT_GT(figures.steps, 30U * 60 / 24) << "no particle moves more than 0.8 in a step";
  EXPECT_LT(figures.steps, 30U * 10);
  EXPECT_EQ(figures.slowed_down, 0U);
}

TEST(ParticleJet, FollowsFreeFall) {
  JetOptions options = small_jet();
  options.viscosity = 0;
  const ParticleJet jet = jet_after(options, 6);
  const points::ParticleSet set = particles_of(jet);
  // After 0.25 s the first layer is where free fall takes it, except for the push of the layers behind it.
  const double time = 0.25;
  glm::dvec3 middle(0);
  for (std::size_t i = 0; i < 29; ++i) middle += set.positions[i] / 29.0;
  EXPECT_NEAR(middle.x, -15 + 0.55 + 60 * time, 1);
  EXPECT_NEAR(middle.y, 0, 0.2);
  EXPECT_NEAR(middle.z, 9 - 98.1 * time * time / 2, 0.5);
}

TEST(ParticleJet, ReportsVelocityAgeAndId) {
  const points::ParticleSet set = particles_of(jet_after(small_jet(), 2));
  ASSERT_EQ(set.attributes.size(), 3U);
  EXPECT_EQ(set.attributes[0].name, "velocity");
  EXPECT_EQ(set.attributes[0].components, 3U);
  EXPECT_EQ(set.attributes[1].name, "age");
  EXPECT_EQ(set.attributes[2].name, "id");
  for (std::size_t i = 0; i < set.size(); ++i) {
    EXPECT_NEAR(set.attributes[0].values[3 * i], 60, 6);
    EXPECT_NEAR(set.attributes[1].values[i], 2.0 / 24 - static_cast<double>(i / 29) / 60, 1e-6);
    EXPECT_EQ(set.attributes[2].values[i], static_cast<float>(i));
  }
}

TEST(ParticleJet, TurnsPositionsAndVelocities) {
  const ParticleJet jet = jet_after(small_jet(), 3);
  const points::ParticleSet z_up = particles_of(jet);
  const auto y_up = jet.particles(Context(), JetUp::y);
  ASSERT_TRUE(y_up);
  ASSERT_EQ(y_up->size(), z_up.size());
  const auto& before = z_up.attributes[0].values;
  const auto& turned = y_up->attributes[0].values;
  for (std::size_t i = 0; i < z_up.size(); ++i) {
    const glm::dvec3 place = z_up.positions[i];
    EXPECT_EQ(y_up->positions[i], glm::dvec3(place.x, place.z, -place.y));
    EXPECT_EQ(turned[3 * i], before[3 * i]);
    EXPECT_EQ(turned[3 * i + 1], before[3 * i + 2]);
    EXPECT_EQ(turned[3 * i + 2], -before[3 * i + 1]);
  }
}

TEST(ParticleJet, IsIndependentOfThreads) {
  std::vector<points::ParticleSet> sets;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    sets.push_back(particles_of(jet_after(small_jet(), 25)));
  }
  EXPECT_TRUE(same_bits(sets[0], sets[1]));
  EXPECT_TRUE(same_bits(sets[0], sets[2]));
}

TEST(ParticleJet, DependsOnSeed) {
  JetOptions options = small_jet();
  const points::ParticleSet zero = particles_of(jet_after(options, 4));
  EXPECT_TRUE(same_bits(zero, particles_of(jet_after(options, 4))));
  options.seed = 1;
  EXPECT_FALSE(same_bits(zero, particles_of(jet_after(options, 4))));
}

TEST(ParticleJet, LosesEnergyAfterLastParticle) {
  JetOptions options = small_jet();
  options.count = 800;
  ParticleJet jet = jet_after(options, 13);
  ASSERT_EQ(jet.size(), options.count);
  const auto energy = [&] {
    const points::ParticleSet set = particles_of(jet);
    double sum = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      sum += options.gravity * (set.positions[i].z + options.tank.z / 2);
      for (int axis = 0; axis < 3; ++axis) sum += std::pow(set.attributes[0].values[3 * i + axis], 2) / 2;
    }
    return sum;
  };
  const double first = energy();
  double last = first;
  for (int frame = 0; frame < 60; ++frame) {
    ASSERT_TRUE(jet.advance(Context()));
    const double now = energy();
    EXPECT_LE(now, last + 1e-3 * first) << frame;
    last = now;
  }
  EXPECT_LT(last, 0.2 * first);
}

TEST(ParticleJet, AcceptsExtremeOptions) {
  const auto sound = [](const JetOptions& options, int frames) {
    const ParticleJet jet = jet_after(options, frames);
    expect_sound(particles_of(jet), options.tank, jet.radius());
    return jet.size();
  };
  JetOptions one;
  one.count = 1;
  EXPECT_EQ(sound(one, 20), 1U);
  JetOptions weightless = small_jet();
  weightless.gravity = 0;
  EXPECT_EQ(sound(weightless, 25), weightless.count);
  JetOptions slow = small_jet();
  slow.fps = 1;
  EXPECT_EQ(sound(slow, 1), slow.count);
  JetOptions stiff = small_jet();
  stiff.gravity = 1e5;
  stiff.viscosity = 0.5;
  stiff.iterations = 1;
  sound(stiff, 3);
  for (const double unit : {1e-6, 1e6}) {
    JetOptions scaled = small_jet();
    scaled.tank *= unit;
    scaled.radius = *scaled.radius * unit;
    scaled.nozzle = *scaled.nozzle * unit;
    scaled.speed *= unit;
    scaled.gravity *= unit;
    EXPECT_EQ(sound(scaled, 25), scaled.count) << unit;
  }
  // Filled up to the nozzle and above it.
  JetOptions full = small_jet();
  full.tank = glm::dvec3(8, 8, 16);
  full.nozzle = 1;
  full.count = 700;
  EXPECT_EQ(sound(full, 80), full.count);
}

TEST(ParticleJet, RejectsInvalidOptions) {
  const auto with = [](const auto& change) {
    JetOptions options = small_jet();
    change(options);
    return refusal(options).message;
  };
  EXPECT_EQ(with([](JetOptions& o) { o.count = 0; }), "expected 1 to 16777216 particles, found 0");
  EXPECT_EQ(with([](JetOptions& o) { o.count = (1U << 24U) + 1; }), "expected 1 to 16777216 particles, found 16777217");
  EXPECT_EQ(with([](JetOptions& o) { o.tank.y = -1; }), "expected a side of the tank above 0, found -1");
  EXPECT_EQ(with([](JetOptions& o) { o.radius = 0; }), "expected a radius of particles above 0, found 0");
  EXPECT_EQ(with([](JetOptions& o) { o.nozzle = kNan; }), "expected a radius of the nozzle above 0, found nan");
  EXPECT_EQ(with([](JetOptions& o) { o.speed = kInfinity; }), "expected a speed above 0, found inf");
  EXPECT_EQ(with([](JetOptions& o) { o.fps = 0; }), "expected a number of frames a second above 0, found 0");
  EXPECT_EQ(with([](JetOptions& o) { o.gravity = -9.81; }), "expected a gravity of 0 or more, found -9.81");
  EXPECT_EQ(with([](JetOptions& o) { o.viscosity = kNan; }), "expected a viscosity from 0 to 0.5, found nan");
  EXPECT_EQ(with([](JetOptions& o) { o.iterations = 0; }), "expected a number of iterations from 1 to 1000, found 0");
  EXPECT_EQ(with([](JetOptions& o) { o.count = 1 << 20; }),
            "expected at most 23328 particles of radius 0.5 in a tank of 30 x 24 x 36, found 1048576");
  EXPECT_NE(with([](JetOptions& o) { o.nozzle = 9; }).find("too small for a nozzle of radius 9"), std::string::npos);
  EXPECT_NE(with([](JetOptions& o) { o.radius = 1e-9; }).find("expected a particle radius of at least"),
            std::string::npos);
  EXPECT_NE(with([](JetOptions& o) { o.radius = 1e-4; }).find("at once; expected at most 1500, for"),
            std::string::npos);
  for (const auto& change : {+[](JetOptions& o) { o.fps = 1e-3; }, +[](JetOptions& o) { o.speed = 1e300; },
                             +[](JetOptions& o) { o.gravity = 1e308; }}) {
    EXPECT_NE(with(change).find("the limit is 10000 steps (a step moves a particle by at most 0.8 particle spacings)"),
              std::string::npos);
  }
}

TEST(ParticleJet, ObeysMemoryBudgetAndCancellation) {
  const Context poor(MemoryBudget(std::uint64_t{1} << 16));
  const auto refused = ParticleJet::make(small_jet(), poor);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::raise, Setting::memory_limit));
  EXPECT_EQ(poor.memory().reserved(), 0U);

  const Context context;
  {
    auto jet = ParticleJet::make(small_jet(), context);
    ASSERT_TRUE(jet);
    EXPECT_GE(context.memory().reserved(), 1500U * 4 * sizeof(glm::dvec3));
    ASSERT_TRUE(jet->advance(context));
    context.cancel();
    const auto ended = jet->advance(context);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, ErrorCode::cancelled);
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::simulate

// A particle fluid: its kernels, its conserved quantities, and its state at rest.
#include "simulate/detail/fluid.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "base/finite.hpp"
#include "base/hash.hpp"

namespace isoextract::simulate {
namespace {

constexpr double kStep = 0.002;
constexpr double kApart = 1.08;

Fluid fluid_of(const FluidOptions& options, const std::vector<glm::dvec3>& places,
               const glm::dvec3& velocity = glm::dvec3(0)) {
  Fluid fluid = std::move(*Fluid::make(options, places.size(), Context()));
  for (const glm::dvec3& place : places) fluid.add(place, velocity);
  return fluid;
}

// Returns a block of a lattice slightly wider than at rest, with jittered particles.
std::vector<glm::dvec3> block(const glm::ivec3& size, const glm::dvec3& low) {
  std::vector<glm::dvec3> places;
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      for (int z = 0; z < size.z; ++z) {
        glm::dvec3 off;
        for (int axis = 0; axis < 3; ++axis) {
          off[axis] = 0.05 * (std::ldexp(static_cast<double>(splitmix64(3 * places.size() + axis)), -63) - 1);
        }
        places.push_back(low + kApart * glm::dvec3(x, y, z) + off);
      }
    }
  }
  return places;
}

glm::dvec3 momentum_of(const Fluid& fluid) {
  glm::dvec3 sum(0);
  for (const glm::dvec3& v : fluid.velocities()) sum += v;
  return sum;
}

// Sums over all pairs, plus the walls near each particle.
std::vector<double> densities_of(const Fluid& fluid, const FluidOptions& options) {
  const FluidKernels kernels(options.spacing);
  std::vector<double> densities;
  for (const glm::dvec3& p : fluid.places()) {
    double density = 0;
    for (const glm::dvec3& q : fluid.places()) {
      const double distance2 = glm::dot(p - q, p - q);
      if (distance2 < kernels.reach2()) density += kernels.density(distance2);
    }
    double inside = 1;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double distance : {p[axis] - options.low[axis], options.high[axis] - p[axis]}) {
        if (distance < kernels.reach()) inside *= 1 - kernels.wall(distance);
      }
    }
    densities.push_back(density + 1 - inside);
  }
  return densities;
}

TEST(FluidKernels, SumToOneOnRestLattice) {
  for (const double spacing : {1e-6, 1.0, 250.0}) {
    const FluidKernels kernels(spacing);
    double density = 0;
    for (int x = -3; x <= 3; ++x) {
      for (int y = -3; y <= 3; ++y) {
        for (int z = -3; z <= 3; ++z) {
          const double distance2 = spacing * spacing * (x * x + y * y + z * z);
          if (distance2 < kernels.reach2()) density += kernels.density(distance2);
        }
      }
    }
    EXPECT_NEAR(density, 1, 1e-12);
  }
  EXPECT_EQ(FluidKernels(3).density(0), FluidKernels::own_density());
}

TEST(FluidKernels, GradientsPointToOtherParticle) {
  const FluidKernels kernels(1);
  const glm::dvec3 d(0.3, -0.6, 0.2);
  const glm::dvec3 gradient = kernels.gradient(d, glm::dot(d, d));
  EXPECT_LT(glm::dot(gradient, d), 0);
  EXPECT_NEAR(glm::length(glm::cross(gradient, d)), 0, 1e-15);
  EXPECT_EQ(kernels.gradient(glm::dvec3(0), 0), glm::dvec3(0));
}

// A wall equals the integral of a kernel over the space behind it, summed here over small cubes.
TEST(FluidKernels, WallsEqualTheIntegralBehindThem) {
  const FluidKernels kernels(1);
  constexpr double kCube = 0.05;
  for (const double distance : {0.0, 0.5, 1.0, 1.7}) {
    double share = 0;
    double slope = 0;
    for (double x = -2 + kCube / 2; x < 2; x += kCube) {
      for (double y = -2 + kCube / 2; y < 2; y += kCube) {
        for (double z = -2 + kCube / 2; z < -distance; z += kCube) {
          const glm::dvec3 d(x, y, z);
          const double distance2 = glm::dot(d, d);
          if (distance2 >= kernels.reach2()) continue;
          share += kernels.density(distance2) * kCube * kCube * kCube;
          slope += kernels.gradient(-d, distance2).z * kCube * kCube * kCube;
        }
      }
    }
    // The sum over the lattice exceeds the integral by 1 %.
    EXPECT_NEAR(kernels.wall(distance), share, 0.02 * share + 1e-3) << distance;
    EXPECT_NEAR(kernels.wall_slope(distance), slope, -0.03 * slope + 1e-3) << distance;
  }
  EXPECT_EQ(kernels.wall(0), 0.5);
  EXPECT_NEAR(kernels.wall(kernels.reach()), 0, 1e-15);
  EXPECT_EQ(kernels.wall_slope(kernels.reach()), 0);
}

TEST(Fluid, LetsParticleFallToTheFloor) {
  FluidOptions options{.low = glm::dvec3(0), .high = glm::dvec3(20), .gravity = 10, .top_speed = 100};
  Fluid fluid = fluid_of(options, {glm::dvec3(10, 10, 15)}, glm::dvec3(1, 0, 0));
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(fluid.step(kStep, Context()));
  EXPECT_NEAR(fluid.places()[0].x, 11, 1e-9);
  EXPECT_NEAR(fluid.places()[0].z, 15 - 10 * 1.0 / 2, 10 * 1.0 * kStep);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(fluid.step(kStep, Context()));
  EXPECT_EQ(fluid.places()[0].z, 0.5);
  EXPECT_EQ(fluid.velocities()[0].z, 0);
  EXPECT_NEAR(fluid.velocities()[0].x, 1, 1e-9);
  EXPECT_EQ(fluid.slowed_down(), 0U);
}

TEST(Fluid, ConservesMomentumAwayFromWalls) {
  FluidOptions options{.low = glm::dvec3(-50), .high = glm::dvec3(50), .viscosity = 0.1, .top_speed = 1000};
  Fluid fluid = std::move(*Fluid::make(options, 1000, Context()));
  for (const glm::dvec3& p : block(glm::ivec3(6), glm::dvec3(-8, 0, 0))) fluid.add(p, glm::dvec3(20, 0, 0));
  for (const glm::dvec3& p : block(glm::ivec3(5), glm::dvec3(2, 1, 0.3))) fluid.add(p, glm::dvec3(-30, 4, 0));
  const glm::dvec3 before = momentum_of(fluid);
  double energy = fluid.energy();
  const double first = energy;
  for (int i = 0; i < 150; ++i) {
    ASSERT_TRUE(fluid.step(kStep, Context()));
    EXPECT_NEAR(glm::length(momentum_of(fluid) - before), 0, 1e-8 * glm::length(before)) << i;
    EXPECT_LE(fluid.energy(), energy + 5e-3 * first) << i;
    energy = fluid.energy();
  }
  EXPECT_LT(energy, 0.9 * first) << "they met";
}

// A column falls, sloshes and comes to rest, no denser than at rest and with the energy of still water.
TEST(Fluid, SettlesAtRestDensity) {
  const FluidOptions options{
      .low = glm::dvec3(0), .high = glm::dvec3(12, 8, 30), .gravity = 98.1, .viscosity = 0.05, .top_speed = 500};
  Fluid fluid = fluid_of(options, block({5, 7, 16}, glm::dvec3(0.6)));
  const double count = 5.0 * 7 * 16;
  const double first = fluid.energy();
  double energy = first;
  double most_growth = 0;
  double all_growth = 0;
  for (int i = 0; i < 750; ++i) {
    ASSERT_TRUE(fluid.step(2 * kStep, Context()));
    most_growth = std::max(most_growth, fluid.energy() - energy);
    all_growth += std::max(0.0, fluid.energy() - energy);
    energy = fluid.energy();
    for (const glm::dvec3& p : fluid.places()) {
      ASSERT_TRUE(glm::all(glm::greaterThanEqual(p, options.low + 0.5)) &&
                  glm::all(glm::lessThanEqual(p, options.high - 0.5)));
    }
  }
  // Corrections are approximate: a particle pushed out of the surface gains a little energy.
  EXPECT_LE(most_growth, 5e-3 * first);
  EXPECT_LE(all_growth, 5e-2 * first);
  const std::vector<double> densities = densities_of(fluid, options);
  double above = 0;
  for (const double density : densities) above += std::max(0.0, density - 1) / count;
  EXPECT_LT(above, 0.01);
  EXPECT_LT(*std::ranges::max_element(densities), 1.1);
  // Half the height of the water on 96 squares of the floor.
  const double level = count / 96 / 2;
  double height = 0;
  for (const glm::dvec3& p : fluid.places()) height += p.z / count;
  EXPECT_NEAR(height, level, 0.3);
  EXPECT_NEAR(energy, count * options.gravity * level, 0.1 * count * options.gravity * level);
}

TEST(Fluid, KeepsCoincidentAndCornerParticlesInside) {
  FluidOptions options{.low = glm::dvec3(0),
                       .high = glm::dvec3(5),
                       .gravity = 1000,
                       .viscosity = 0.5,
                       .iterations = 20,
                       .top_speed = 200};
  std::vector<glm::dvec3> places(60, glm::dvec3(2.5));
  places.insert(places.end(), 20, glm::dvec3(0.5));
  places.insert(places.end(), 20, glm::dvec3(4.5, 0.5, 4.5));
  for (int i = 0; i < 5; ++i) places.emplace_back(1, 1, 1 + 1e-12 * i);
  Fluid fluid = fluid_of(options, places);
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(fluid.step(kStep, Context()));
    for (std::size_t k = 0; k < fluid.size(); ++k) {
      const glm::dvec3& p = fluid.places()[k];
      ASSERT_TRUE(is_finite(p) && is_finite(fluid.velocities()[k]));
      ASSERT_TRUE(glm::all(glm::greaterThanEqual(p, glm::dvec3(0.5))) &&
                  glm::all(glm::lessThanEqual(p, glm::dvec3(4.5))));
    }
    ASSERT_LE(fluid.fastest(), options.top_speed * (1 + 1e-12));
  }
  EXPECT_GT(fluid.slowed_down(), 0U) << "heaps burst";
}

TEST(Fluid, KeepsNumbersWithParticles) {
  FluidOptions options{.low = glm::dvec3(-200), .high = glm::dvec3(200), .top_speed = 100};
  Fluid fluid = std::move(*Fluid::make(options, 50, Context()));
  for (int i = 0; i < 50; ++i) fluid.add(glm::dvec3(-20 + 37 * i % 50, 5 * i % 50, 3 * i), glm::dvec3(0.25 * i, 0, 0));
  const std::vector<glm::dvec3> before(fluid.places().begin(), fluid.places().end());
  ASSERT_TRUE(fluid.step(1, Context()));
  std::vector<bool> found(50);
  for (std::size_t k = 0; k < 50; ++k) {
    const std::uint32_t number = fluid.numbers()[k];
    found[number] = true;
    EXPECT_EQ(fluid.places()[k], before[number] + glm::dvec3(0.25 * number, 0, 0));
  }
  EXPECT_TRUE(std::ranges::all_of(found, [](bool b) { return b; }));
}

}  // namespace
}  // namespace isoextract::simulate

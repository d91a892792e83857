// Tests kernel fields against sums over all particles, for several thread counts and unfavorable particle positions.
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "points/detail/neighbor_batches.hpp"
#include "points/detail/symmetric_eigen.hpp"
#include "support/hints.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kRadius = 0.025;

// The cubic spline with its normalization, as in textbooks; h is the support.
double textbook_kernel(double r, double h) {
  const double q = 2 * r / h;
  const double scale = 8 / (h * h * h);
  if (q < 1) return scale * 3 / (2 * std::numbers::pi) * (2.0 / 3 - q * q + 0.5 * q * q * q);
  if (q < 2) return scale / (4 * std::numbers::pi) * std::pow(2 - q, 3);
  return 0;
}

std::vector<double> textbook_densities(const std::vector<glm::dvec3>& positions, double mass, double h) {
  std::vector<double> densities(positions.size(), 0);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (const glm::dvec3& p : positions) densities[i] += mass * textbook_kernel(glm::length(p - positions[i]), h);
  }
  return densities;
}

// Expects that every stored sample equals `expected` at its world position, and that `expected` is 0 elsewhere.
template <class F>
void expect_field(const ParticleField& made, const F& expected, double tolerance) {
  const field::Affine& world = made.field.index_to_world;
  std::size_t positive = 0;
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    const double truth = expected(world(glm::dvec3(at)));
    EXPECT_NEAR(static_cast<double>(value), truth, tolerance * (1 + truth));
    positive += static_cast<std::size_t>(truth > 1e-9);
  });
  EXPECT_GT(positive, 100U);
  const field::SparseLookup lookup(samples_of(made));
  for (const field::SparseBlock& block : samples_of(made).blocks) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const int side : {-1, 8}) {
        glm::ivec3 beside = block.origin + 3;
        beside[axis] = block.origin[axis] + side;
        if (lookup.block(field::block_origin(beside)) < 0) {
          EXPECT_LT(expected(world(glm::dvec3(beside))), 1e-9);
        }
      }
    }
  }
}

TEST(SphField, EqualsTheSumOverAllParticles) {
  for (const double smoothing : {1.3, 2.0}) {
    for (const double cell : {0.75, 1.9}) {
      std::vector<glm::dvec3> positions = random_positions(60, 0.3, 21);
      positions.insert(positions.end(), {positions[3], positions[3], {1.2, -0.4, 0.9}});  // coincident particles, and
                                                                                          // an isolated one
      FieldOptions options;
      options.radius = kRadius;
      options.smoothing_length = smoothing;
      options.cell_size = cell;
      const ParticleField made = field_of(particles_at(positions), options);
      const double h = 2 * smoothing * kRadius;
      const double mass = 1000 * std::pow(2 * kRadius, 3);
      const std::vector<double> densities = textbook_densities(positions, mass, h);
      expect_field(
          made,
          [&](const glm::dvec3& x) {
            double sum = 0;
            for (std::size_t j = 0; j < positions.size(); ++j) {
              sum += mass / densities[j] * textbook_kernel(glm::length(x - positions[j]), h);
            }
            return sum;
          },
          1e-5);
      EXPECT_DOUBLE_EQ(made.figures.support, h);
      EXPECT_DOUBLE_EQ(made.figures.spacing, cell * kRadius);
      EXPECT_EQ(made.figures.particles, positions.size());
    }
  }
}

TEST(AnisotropicField, MatchesTheEquations) {
  std::vector<glm::dvec3> positions = random_positions(250, 0.3, 22);
  for (glm::dvec3& p : positions) p.z *= 0.3;  // a sheet
  positions.emplace_back(1.2, -0.4, 0.9);      // an isolated particle
  FieldOptions options;
  options.method = Method::anisotropic;
  options.radius = kRadius;
  const AnisotropyOptions& k = options.anisotropy;
  const double h = 2 * options.smoothing_length * kRadius;
  const double r = k.neighborhood * h;
  const std::vector<double> densities = textbook_densities(positions, 1, h);
  struct Kernel {
    glm::dvec3 center;
    glm::dmat3 g;
    double volume;
  };
  const double shortest = std::max(k.shortest, 3 * method_info(options.method).cell_size * kRadius / h);
  std::vector<Kernel> kernels;
  std::size_t flat = 0;
  std::size_t between = 0;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    double total = 0;
    glm::dvec3 mean(0);
    const auto w = [&](std::size_t j) {
      const double d = glm::length(positions[j] - positions[i]);
      return d < r ? 1 - std::pow(d / r, 3) : 0;
    };
    for (std::size_t j = 0; j < positions.size(); ++j) {
      total += w(j);
      mean += w(j) * positions[j];
    }
    mean /= total;
    glm::dmat3 c(0.0);
    for (std::size_t j = 0; j < positions.size(); ++j) {
      c += w(j) / total * glm::outerProduct(positions[j] - mean, positions[j] - mean);
    }
    const SymmetricEigen eigen = symmetric_eigen(c);
    const glm::dvec3 s = eigen.values;
    glm::dvec3 axes(k.k_n);
    const double full = std::min(2 * (total - 1) / k.few, s.x / (k.k_n * 0.15 * r * r));
    if (full > 1) {
      const double wide = 1 + (k.widest - 1) * std::clamp((1 - s.z / s.x - 0.1) / 0.6, 0.0, 1.0);
      axes = glm::mix(axes, glm::max(wide * s / s.x, glm::dvec3(shortest)), std::min(full - 1, 1.0));
      flat += static_cast<std::size_t>(axes.z < 0.5 * axes.x);
      between += static_cast<std::size_t>(full < 2);
    }
    glm::dmat3 g(0.0);
    for (int n = 0; n < 3; ++n) g += glm::outerProduct(eigen.vectors[n], eigen.vectors[n]) / (h * axes[n]);
    glm::dvec3 center = positions[i];
    const double length = glm::length(mean - positions[i]);
    if (length > 0.2 * h) {
      const glm::dvec3 inward = (mean - positions[i]) / length;
      double depths = 0;
      double weights = 0;
      for (const glm::dvec3& p : positions) {
        const glm::dvec3 d = p - positions[i];
        const double depth = glm::dot(d, inward);
        const double weight = std::pow(std::max(1 - glm::dot(d, d) / (1.96 * h * h), 0.0), 2) *
                              std::pow(std::max(1 - depth * depth / (0.25 * h * h), 0.0), 2);
        depths += weight * depth;
        weights += weight;
      }
      center += k.lambda * std::min(length / (0.2 * h) - 1, 1.0) * depths / weights * inward;
      moved += static_cast<std::size_t>(center != positions[i]);
    }
    kernels.push_back({center, g, 1 / densities[i]});
  }
  EXPECT_GT(between, 3U);
  EXPECT_GT(moved, 100U);
  EXPECT_GT(flat, 100U);
  expect_field(
      field_of(particles_at(positions), options),
      [&](const glm::dvec3& x) {
        double sum = 0;
        for (const Kernel& kernel : kernels) {
          sum += kernel.volume * glm::determinant(kernel.g) *
                 textbook_kernel(glm::length(kernel.g * (x - kernel.center)), 1);
        }
        return sum;
      },
      2e-4);
}

TEST(ParticleField, IsTheSameForAnyNumberOfThreads) {
  const ParticleSet particles = particles_at(lattice_ball(kRadius, 0.5, 0.4));
  for (const Method method : {Method::weight, Method::sph, Method::anisotropic}) {
    FieldOptions options;
    options.method = method;
    options.tile_iso = method_info(method).iso;
    std::optional<ParticleField> first;
    for (const std::size_t threads : {1U, 2U, 5U}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      ParticleField made = field_of(particles, options);
      if (!first) {
        first = std::move(made);
        continue;
      }
      EXPECT_TRUE(same_samples(samples_of(*first), samples_of(made))) << word_of(method);
      EXPECT_EQ(first->figures.particles_deep_inside, made.figures.particles_deep_inside);
      EXPECT_EQ(first->figures.radius, made.figures.radius);
    }
  }
}

TEST(ParticleField, StoresSortedBlocksOnMultiplesOfTheSpacing) {
  std::vector<glm::dvec3> positions = random_positions(50, 0.2, 23);
  for (glm::dvec3& p : positions) p += glm::dvec3(-7.3, 11.9, 0.01);
  FieldOptions options;
  options.radius = kRadius;
  options.spacing = 0.02;
  const ParticleField made = field_of(particles_at(positions), options);
  const field::SparseSamples& samples = samples_of(made);
  ASSERT_GT(samples.blocks.size(), 10U);
  std::uint64_t active = 0;
  glm::ivec3 low(1 << 30);
  glm::ivec3 high(-(1 << 30));
  for (std::size_t b = 0; b < samples.blocks.size(); ++b) {
    const glm::ivec3& o = samples.blocks[b].origin;
    EXPECT_EQ(o & 7, glm::ivec3(0));
    if (b > 0) {
      const glm::ivec3& p = samples.blocks[b - 1].origin;
      EXPECT_LT(std::tuple(p.x, p.y, p.z), std::tuple(o.x, o.y, o.z));
    }
  }
  for_each_sample(made, [&](const glm::ivec3& at, float value) {
    if (value == 0) return;
    ++active;
    low = glm::min(low, at);
    high = glm::max(high, at);
  });
  EXPECT_EQ(samples.active_voxels, active);
  EXPECT_EQ(samples.active_box, (field::IndexBox{low, high}));
  EXPECT_EQ(samples.background, 0);
  const glm::dvec3 of_spacing = made.field.index_to_world(glm::dvec3(samples.blocks[0].origin)) / 0.02;
  EXPECT_LT(glm::length(of_spacing - glm::round(of_spacing)), 1e-9);
}

TEST(ParticleField, IsTheSameAMillionUnitsAway) {
  const std::vector<glm::dvec3> positions = random_positions(300, 0.4, 24);
  FieldOptions options;
  options.radius = kRadius;
  options.spacing = 0.0625 / 4;  // so that a translation by whole bricks is exact
  for (const Method method : {Method::sph, Method::anisotropic}) {
    options.method = method;
    const ParticleField here = field_of(particles_at(positions), options);
    const glm::dvec3 offset(1e7, -1e7, 5e6);
    std::vector<glm::dvec3> moved = positions;
    for (glm::dvec3& p : moved) p += offset;
    const ParticleField there = field_of(particles_at(moved), options);
    ASSERT_EQ(samples_of(here).blocks.size(), samples_of(there).blocks.size());
    EXPECT_EQ(there.field.index_to_world.offset, here.field.index_to_world.offset + offset);
    double worst = 0;
    for (std::size_t b = 0; b < samples_of(here).blocks.size(); ++b) {
      ASSERT_EQ(samples_of(here).blocks[b].origin, samples_of(there).blocks[b].origin);
      const auto* p = static_cast<const float*>(samples_of(here).blocks[b].values);
      const auto* q = static_cast<const float*>(samples_of(there).blocks[b].values);
      for (int v = 0; v < 512; ++v) worst = std::max(worst, static_cast<double>(std::abs(p[v] - q[v])));
    }
    EXPECT_LT(worst, 1e-5) << "a position has a ten-millionth of the radius there";
  }
}

TEST(ParticleField, MergesCoincidentParticles) {
  for (const Method method : {Method::sph, Method::anisotropic}) {
    FieldOptions options;
    options.method = method;
    options.radius = kRadius;
    options.anisotropy.few = 1 << 30;  // every particle has few neighbors
    const ParticleField one = field_of(particles_at({{0.1, 0.2, 0.3}}), options);
    const ParticleField many = field_of(particles_at(std::vector<glm::dvec3>(100000, {0.1, 0.2, 0.3})), options);
    EXPECT_TRUE(same_samples(samples_of(one), samples_of(many))) << "their volumes are shared";
    options.anisotropy.few = 25;
    EXPECT_TRUE(same_samples(
        samples_of(one), samples_of(field_of(particles_at(std::vector<glm::dvec3>(100, {0.1, 0.2, 0.3})), options))));
  }
}

TEST(ParticleField, IsEmptyWithoutParticles) {
  for (const Method method : {Method::weight, Method::sph, Method::anisotropic}) {
    FieldOptions options;
    options.method = method;
    const ParticleField made = field_of(particles_at({}), options);
    EXPECT_TRUE(samples_of(made).blocks.empty());
    EXPECT_EQ(made.figures.particles, 0U);
    EXPECT_EQ(made.field.source, "test.ply");
  }
}

TEST(ParticleField, ReportsOrDropsNonFinitePositions) {
  std::vector<glm::dvec3> positions = random_positions(40, 0.2, 25);
  FieldOptions options;
  options.radius = kRadius;
  const ParticleField sound = field_of(particles_at(positions), options);
  positions.insert(positions.begin() + 7, {0, std::numeric_limits<double>::quiet_NaN(), 0});
  positions.emplace_back(std::numeric_limits<double>::infinity(), 0, 0);
  const auto refused = make_field(particles_at(positions), options, Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::input);
  EXPECT_NE(refused.error().message.find("particle 7"), std::string::npos) << refused.error().message;
  options.non_finite = NonFiniteParticles::skip;
  const ParticleField made = field_of(particles_at(positions), options);
  EXPECT_EQ(made.figures.particles, 40U);
  EXPECT_EQ(made.figures.particles_dropped, 2U);
  EXPECT_TRUE(same_samples(samples_of(sound), samples_of(made)));
}

TEST(ParticleField, SuggestsARadiusThatFitsTheDensity) {
  FieldOptions options;
  const ParticleField made = field_of(particles_at(lattice_ball(kRadius, 0.2)), options);
  EXPECT_NEAR(made.figures.radius, kRadius, 0.04 * kRadius);
  EXPECT_TRUE(made.figures.radius_suggested);
  const auto refused = make_field(particles_at(std::vector<glm::dvec3>(5, {1, 2, 3})), options, Context());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("found 5 particles at one position"), std::string::npos)
      << refused.error().message;
}

// Measures the work of kernels as the number of particle pairs within reach, not as time.
TEST(ParticleField, HasLinearWork) {
  constexpr double kSide = 4;
  const auto pairs_of = [](const std::vector<glm::dvec3>& positions) {
    const auto grid = CellGrid::make(positions, GridFrame{}, kSide, CellGrid::Coinciding::merged, Context(), "test");
    if (!grid) throw std::runtime_error(grid.error().message);
    return std::pair(count_candidate_pairs(*grid, kSide, ~std::uint64_t{0}), std::uint64_t{grid->size()});
  };
  // Twice as many particles at the same distances: about twice as many pairs.
  const auto [loose, loose_spots] = pairs_of(random_positions(4000, 40, 1));
  std::vector<glm::dvec3> twice = random_positions(4000, 40, 1);
  for (const glm::dvec3& p : random_positions(4000, 40, 2)) twice.push_back(p + glm::dvec3(40, 0, 0));
  const auto [looser, looser_spots] = pairs_of(twice);
  EXPECT_EQ(looser_spots, 2 * loose_spots);
  EXPECT_GT(looser, 19 * loose / 10);
  EXPECT_LT(looser, 23 * loose / 10);
  // All particles are in one cell: each is a neighbor of all.
  const auto [crowd, spots] = pairs_of(random_positions(5000, 1, 3));
  EXPECT_EQ(crowd, spots * spots);

  // make_field() rejects such a crowd before summing pairs if they exceed the limit per particle.
  for (const Method method : {Method::sph, Method::anisotropic}) {
    for (const std::size_t count : {std::size_t{20000}, std::size_t{40000}}) {
      const ParticleSet particles = particles_at(random_positions(count, 0.5, 4));
      FieldOptions options;
      options.method = method;
      options.radius = 1;
      const auto made = make_field(particles, options, Context());
      EXPECT_EQ(made.has_value(), count == 20000) << count;
      if (made) continue;
      EXPECT_EQ(made.error().code, ErrorCode::input);
      for (const char* part : {"test.ply: neighborhoods with a reach of ", " hold too many of the 40000 particles: ",
                               "expected at most 32768 on average in a cube of edge "}) {
        EXPECT_NE(made.error().message.find(part), std::string::npos) << made.error().message;
      }
      EXPECT_TRUE(test::has_step(made.error().hint, Remedy::give, Setting::radius));
      EXPECT_NE(test::text_of(made.error().hint).find("fits the density of the particles"), std::string::npos);
    }
  }
}

TEST(ParticleField, RejectsInvalidOptions) {
  const ParticleSet particles = particles_at(random_positions(10, 1, 26));
  const auto refuses = [&](const ParticleSet& set, ErrorCode code, const char* words, auto change) {
    FieldOptions options;
    options.radius = kRadius;
    change(options);
    const auto refused = make_field(set, options, Context());
    ASSERT_FALSE(refused) << words;
    EXPECT_EQ(refused.error().code, code);
    EXPECT_NE(refused.error().message.find(words), std::string::npos) << refused.error().message;
  };
  const auto usage = [&](const char* words, auto change) { refuses(particles, ErrorCode::usage, words, change); };
  usage("particle radius above 0", [](FieldOptions& o) { o.radius = -1; });
  usage("cell size in radii above 0", [](FieldOptions& o) { o.cell_size = 0; });
  usage("spacing of the samples above 0", [](FieldOptions& o) { o.spacing = std::nan(""); });
  usage("margin of at least 0", [](FieldOptions& o) { o.margin = -1; });
  usage("found both", [](FieldOptions& o) { o.spacing = o.cell_size = 1; });
  usage("smoothing length", [](FieldOptions& o) { o.smoothing_length = 0; });
  usage("weight above 0", [](FieldOptions& o) { o.weight = -0.1; });
  usage("lambda", [](FieldOptions& o) { o.anisotropy.lambda = 1.1; });
  usage("along a surface", [](FieldOptions& o) { o.anisotropy.widest = 0.9; });
  usage("shortest axis", [](FieldOptions& o) { o.anisotropy.shortest = 0; });
  usage("shortest axis", [](FieldOptions& o) { o.anisotropy.shortest = 1.1; });
  usage("k_n", [](FieldOptions& o) { o.anisotropy.k_n = 1.1; });
  usage("k_n", [](FieldOptions& o) { o.anisotropy.k_n = -1; });
  usage("N_eps", [](FieldOptions& o) { o.anisotropy.few = -1; });
  usage("neighborhood", [](FieldOptions& o) { o.anisotropy.neighborhood = 0; });
  usage("finite iso value", [](FieldOptions& o) { o.tile_iso = std::nan(""); });
  usage("at most the reach of a kernel", [](FieldOptions& o) { o.cell_size = 4.5; });
  const auto input = [&](const std::vector<glm::dvec3>& at, const char* words) {
    refuses(particles_at(at), ErrorCode::input, words, [](FieldOptions&) {});
  };
  input({{0, 0, 0}, {1e8, 0, 0}}, "the particles extend over");
  input({{-1e308, 0, 0}, {1e308, 0, 0}}, "the particles extend over");
  input({{1e14, 0, 0}, {1e14, 1, 0}}, "double precision is too coarse");
}

}  // namespace
}  // namespace isoextract::points

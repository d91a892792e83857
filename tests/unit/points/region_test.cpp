// Tests that particles restricted to a region have the field of all particles there.
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include <gtest/gtest.h>

#include "points/region.hpp"
#include "points/selection.hpp"
#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

const SimulationBox kUpright{{-1, -1, -1}, glm::dmat3(2, 0, 0, 0, 2.6, 0, 0, 0, 1.8), {true, true, true}};
const SimulationBox kTilted{{-1, -1, -1}, glm::dmat3(2, 0, 0, 0.5, 1.8, 0, -0.3, 0.6, 2), {true, true, true}};
const SimulationBox kTube{{-1, -1, -1}, glm::dmat3(2, 0, 0, 0, 2, 0, 0, 0, 2), {true, false, false}};

enum class Radii { one, unlike };

struct RegionCase {
  const char* name;
  Method method;
  Radii radii = Radii::one;
  std::optional<SimulationBox> box = {};

  // Smaller ones in a box, so that a part of it is far from the region.
  [[nodiscard]] double radius() const { return box ? 0.04 : 0.1; }
};

// Returns particles around the region and far from it, with surfaces everywhere.
ParticleSet some_particles(const RegionCase& test) {
  const auto positions = lattice(
      test.radius(), test.box ? 13 : 12,
      [](const glm::dvec3& p) { return std::sin(4 * p.x) + std::cos(5 * p.y) > p.z; }, 0.4);
  ParticleSet set = particles_at(positions);
  set.box = test.box;
  if (test.radii == Radii::one) return set;
  ParticleAttribute radii{"radius", 1, Buffer<float>(set.size())};
  for (std::size_t i = 0; i < set.size(); ++i) {
    // Smaller ones in the region than elsewhere, so that the median differs.
    const bool is_near = glm::length(set.positions[i]) < 0.5;
    radii.values[i] = static_cast<float>(test.radius() * (is_near ? 0.8 : 1.0) * (i % 3 == 0 ? 1.3 : 1.0));
  }
  set.attributes.push_back(std::move(radii));
  return set;
}

ParticleSet copy_of(const ParticleSet& set) {
  std::vector<std::uint32_t> all(set.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  return std::move(*take_particles(set, all, Context()));
}

float value_at(const ParticleField& made, const field::SparseLookup& lookup, const glm::ivec3& at) {
  const std::int32_t block = lookup.block(field::block_origin(at));
  if (block < 0) return 0;
  const auto* values = static_cast<const float*>(samples_of(made).blocks[static_cast<std::size_t>(block)].values);
  return values[field::block_offset(at)];
}

class FieldOfARegion : public testing::TestWithParam<RegionCase> {};

TEST_P(FieldOfARegion, EqualsTheFieldOfAllParticles) {
  const RegionCase& test = GetParam();
  const ParticleSet all = some_particles(test);
  ParticleSet part = copy_of(all);
  // In the second box, the region reaches the upper face along x: the images of particles at the lower face count.
  const field::Box region =
      test.box ? field::Box{{0.4, -0.3, -0.5}, {1, 0.2, 0}} : field::Box{{-0.3, -0.3, -0.4}, {0.3, 0.2, 0.1}};
  FieldOptions options;
  options.method = test.method;
  if (test.radii == Radii::one) options.radius = test.radius();
  // Samples so near to each other that kernels reach farther than the margin of samples around the region.
  options.cell_size = test.method == Method::weight ? 1 : 0.3;
  options.anisotropy.neighborhood = test.box ? 1 : 2;
  options.weight = 2;
  options.margin = 2;
  const auto removed = keep_region(part, region, options, Context());
  ASSERT_TRUE(removed) << removed.error().message;
  EXPECT_EQ(*removed, all.size() - part.size());
  EXPECT_GT(*removed, all.size() / 20);
  const ParticleField whole = field_of(all, options);
  const ParticleField cropped = field_of(part, options);
  EXPECT_EQ(cropped.figures.radius, whole.figures.radius);
  EXPECT_EQ(cropped.figures.spacing, whole.figures.spacing);

  const field::SparseLookup lookup(samples_of(whole));
  const field::SparseLookup cropped_lookup(samples_of(cropped));
  const field::Affine& map = whole.field.index_to_world;
  const field::Box samples = field::image_of(map.inverse(), region);
  const field::Affine to_cropped = cropped.field.index_to_world.inverse().after(map);
  // Of cells, of an extraction, and the margin.
  const field::IndexBox period = whole.region.value_or(field::IndexBox{glm::ivec3(-1000), glm::ivec3(1000)});
  const glm::ivec3 low = glm::max(glm::ivec3(glm::floor(samples.min)), period.min) - 4;
  const glm::ivec3 high = glm::min(glm::ivec3(glm::ceil(samples.max)), period.max) + 4;
  std::size_t inside = 0;
  std::size_t outside = 0;
  for (int x = low.x; x <= high.x; ++x) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z; ++z) {
        const float truth = value_at(whole, lookup, {x, y, z});
        const glm::ivec3 at(glm::round(to_cropped(glm::dvec3(x, y, z))));
        ASSERT_NEAR(value_at(cropped, cropped_lookup, at), truth, 1e-5) << x << " " << y << " " << z;
        ++(static_cast<double>(truth) > method_info(test.method).iso ? inside : outside);
      }
    }
  }
  EXPECT_GT(inside, 20U);
  EXPECT_GT(outside, 20U);
}

INSTANTIATE_TEST_SUITE_P(OfEachMethod, FieldOfARegion,
                         testing::Values(RegionCase{"weight", Method::weight}, RegionCase{"sph", Method::sph},
                                         RegionCase{"anisotropic", Method::anisotropic},
                                         RegionCase{"weight_unlike", Method::weight, Radii::unlike},
                                         RegionCase{"sph_unlike", Method::sph, Radii::unlike},
                                         RegionCase{"anisotropic_unlike", Method::anisotropic, Radii::unlike},
                                         RegionCase{"weight_box", Method::weight, Radii::one, kUpright},
                                         RegionCase{"sph_box", Method::sph, Radii::one, kUpright},
                                         RegionCase{"sph_unlike_box", Method::sph, Radii::unlike, kUpright},
                                         RegionCase{"sph_tilted", Method::sph, Radii::one, kTilted},
                                         RegionCase{"sph_tube", Method::sph, Radii::one, kTube},
                                         RegionCase{"anisotropic_tube", Method::anisotropic, Radii::one, kTube}),
                         [](const auto& tested) { return tested.param.name; });

TEST(Region, SuggestsTheRadiusOfTheParticlesInside) {
  // Fine particles in the region, coarse ones around it, and strays.
  std::vector<glm::dvec3> positions = lattice(
      0.05, 10, [](const glm::dvec3&) { return true; }, 0.2);
  const std::size_t fine = positions.size();
  for (const glm::dvec3& p : lattice(
           0.2, 9, [](const glm::dvec3& q) { return glm::length(q) > 2; }, 0.2)) {
    positions.push_back(p);
  }
  positions.emplace_back(1e8, 0, 0);
  positions.emplace_back(0, -1e300, 0);
  positions.emplace_back(std::numeric_limits<double>::quiet_NaN(), 0, 0);
  ParticleSet set = particles_at(positions);
  FieldOptions options;
  options.non_finite = NonFiniteParticles::skip;
  const field::Box region{glm::dvec3(-1.2), glm::dvec3(1.2)};
  ASSERT_TRUE(keep_region(set, region, options, Context()));
  EXPECT_NEAR(options.suggested_radius.value_or(0), 0.05, 0.002);
  const ParticleField made = field_of(set, options);
  EXPECT_GE(made.figures.particles, fine);
  EXPECT_LT(made.figures.particles, fine + 400);
  EXPECT_EQ(made.figures.particles_dropped, 1U);
  EXPECT_TRUE(made.figures.radius_suggested);
}

TEST(Region, SuggestsTheRadiusOfAllParticlesIfEmpty) {
  ParticleSet set = particles_at(lattice(0.05, 6, [](const glm::dvec3&) { return true; }));
  FieldOptions options;
  const auto removed = keep_region(set, {glm::dvec3(5), glm::dvec3(6)}, options, Context());
  ASSERT_TRUE(removed);
  EXPECT_EQ(set.size(), 0U);
  EXPECT_NEAR(options.suggested_radius.value_or(0), 0.05, 0.003);
}

TEST(Region, KeepsAllParticlesIfOutsideThePeriodicBox) {
  ParticleSet set = particles_at(random_positions(50, 1, 3));
  set.box = kUpright;
  FieldOptions options;
  EXPECT_EQ(*keep_region(set, {glm::dvec3(5), glm::dvec3(6)}, options, Context()), 0U);
  EXPECT_EQ(*keep_inside(set, {glm::dvec3(5), glm::dvec3(6)}, Context()), 0U);
  EXPECT_EQ(*keep_inside(set, {glm::dvec3(-9), glm::dvec3(9)}, Context()), 0U);
}

TEST(Region, KeepsParticlesWhoseImagesLieInside) {
  // The box is from -1 to 1 along x: 3.2 and -4.9 are images of -0.8 and -0.9; 0 is outside the region.
  ParticleSet set = particles_at({{-0.8, 0, 0}, {3.2, 0, 0}, {-4.9, 0.1, 0}, {0, 0, 0}, {-0.8, 2, 0}});
  set.box = kTube;
  EXPECT_EQ(*keep_inside(set, {{-1, -0.5, -0.5}, {-0.7, 0.5, 0.5}}, Context()), 2U);
  ASSERT_EQ(set.size(), 3U);
  EXPECT_EQ(set.positions[2].x, -4.9);
}

}  // namespace
}  // namespace isoextract::points

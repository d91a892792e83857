// Tests files of other programs: counts, bounds and sums computed by NumPy from the bytes, and by VTK for its files.
#include <limits>

#include "support/data_folder.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

particle_io::ParticleFile read_real(const std::string& name, const particle_io::ParticleReadOptions& options = {}) {
  auto read = particle_io::read_particles(data_file(name).string(), options, Context());
  if (!read) throw std::runtime_error(read.error().message);
  return std::move(*read);
}

void expect_place(const points::ParticleSet& set, const glm::dvec3& low, const glm::dvec3& high,
                  const glm::dvec3& sum) {
  glm::dvec3 least(std::numeric_limits<double>::infinity());
  glm::dvec3 greatest = -least;
  glm::dvec3 total(0);
  for (const glm::dvec3& p : set.positions) {
    least = glm::min(least, p);
    greatest = glm::max(greatest, p);
    total += p;
  }
  EXPECT_EQ(least, low);
  EXPECT_EQ(greatest, high);
  expect_near(total, sum, 1e-9);
}

TEST(RealParticles, ReadBgeoAttributesOfDamBreak) {
  ISOEXTRACT_NEEDS_DATA("particles/dam_break_frame_9_6859_particles.bgeo");
  const auto read = read_real("particles/dam_break_frame_9_6859_particles.bgeo", with_all());
  ASSERT_EQ(read.particles.size(), 6859U);
  expect_place(read.particles, {-1.9516323804855347, 0.03568214178085327, -0.7104318737983704},
               {-0.3876219689846039, 0.6816501021385193, 0.7108961343765259},
               {-9602.484628915787, 1793.4332971461117, -0.04677293076747446});
  EXPECT_EQ(attribute_named(read.particles, "id").values[0], 30);
  EXPECT_EQ(attribute_named(read.particles, "density").values[6858], 654.8408F);
  EXPECT_EQ(attribute_named(read.particles, "velocity").values[1], -0.41762838F);
}

TEST(RealParticles, ReadBgeoOctocat) {
  ISOEXTRACT_NEEDS_DATA("particles/octocat_32614_particles.bgeo");
  const auto read = read_real("particles/octocat_32614_particles.bgeo", with_all());
  ASSERT_EQ(read.particles.size(), 32614U);
  EXPECT_TRUE(read.particles.attributes.empty());
  expect_place(read.particles, {-2.306645154953003, -2.2674906253814697, -0.012394733726978302},
               {2.284348487854004, 2.2686853408813477, 1.6760996580123901},
               {198.1827087212382, 623.5186667791277, 18678.99574076009});
}

TEST(RealParticles, ReadPlySequenceOfQuickLiquid) {
  ISOEXTRACT_NEEDS_DATA("particles/flip_quickliquid/flip_0005.ply");
  const std::size_t counts[] = {41826, 42530, 42610, 34361, 45757, 69361, 77495, 80095};
  for (int i = 0; i < 8; ++i) {
    const auto read = read_real(fmt::format("particles/flip_quickliquid/flip_{:04}.ply", 5 * (i + 1)), with_all());
    EXPECT_EQ(read.particles.size(), counts[i]);
    ASSERT_EQ(read.particles.attributes.size(), 1U);
    EXPECT_EQ(read.particles.attributes[0].components, 3U);
    if (i < 7) continue;
    expect_place(read.particles, {0.09375, 0.09372900426387787, 0.0937703400850296},
                 {3.937459945678711, 3.9374189376831055, 5.90604829788208},
                 {162057.7267070338, 164280.5570518896, 148398.52882624418});
    EXPECT_EQ(read.particles.attributes[0].values[0], -0.3537066F);
  }
}

TEST(RealParticles, ReadCsvSequenceOfPeridynamics) {
  ISOEXTRACT_NEEDS_DATA("particles/lammps_peri/peri_1000.csv");
  const auto read = read_real("particles/lammps_peri/peri_1000.csv", with_attributes({"damage"}));
  ASSERT_EQ(read.particles.size(), 3487U);
  expect_place(read.particles, {-0.00500033, -0.0132326, -0.00500034}, {0.00500034, 0.0195984, 0.00500033},
               {1.878584420626772e-07, -9.025411313570006, -1.67085092936739e-07});
  EXPECT_EQ(std::ranges::max(attribute_named(read.particles, "damage").values), 1);
}

}  // namespace
}  // namespace isoextract::test

#include "points/sphere_set.hpp"

#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "unit/points/particles.hpp"

namespace isoextract::points {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ParticleSet with_radii(const std::vector<glm::dvec3>& positions, const std::string& name,
                       const std::vector<float>& radii) {
  ParticleSet set = particles_at(positions);
  ParticleAttribute& attribute = set.attributes.emplace_back();
  attribute.name = name;
  attribute.values = Buffer<float>(radii.size());
  std::ranges::copy(radii, attribute.values.begin());
  return set;
}

FieldOptions spheres() {
  FieldOptions options;
  options.method = Method::spheres;
  return options;
}

TEST(SphereSet, TakesRadiiFromOptionAttributeOrDistances) {
  const std::vector<glm::dvec3> positions{{0, 0, 0}, {2, 0, 0}, {4, 0, 0}};
  const ParticleSet set = with_radii(positions, "radius", {0.5F, 3, 1});
  const auto own = make_spheres(set, spheres(), Context());
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_EQ(&own->particles(), &set);
  ASSERT_EQ(own->radii().size(), 3U);
  EXPECT_EQ(own->radii()[1], 3);
  EXPECT_EQ(own->figures().radius, 1) << "their median";
  EXPECT_EQ(own->figures().radius_attribute, "radius");
  EXPECT_EQ(own->figures().spacing, 0.5);
  EXPECT_EQ(own->figures().support, 0);
  FieldOptions given = spheres();
  given.method = Method::smooth;
  given.radius = 0.25;
  const auto one = make_spheres(set, given, Context());
  ASSERT_TRUE(one);
  EXPECT_TRUE(one->radii().empty());
  EXPECT_EQ(one->figures().radius, 0.25);
  EXPECT_EQ(one->figures().support, 1);
  EXPECT_TRUE(one->figures().radius_attribute.empty());
  const auto suggested = make_spheres(with_radii(positions, "Radius", {0.5F, 3, 1}), spheres(), Context());
  ASSERT_TRUE(suggested);
  EXPECT_TRUE(suggested->figures().radius_suggested);
  EXPECT_NEAR(suggested->figures().radius, 1, 1e-9);
}

TEST(SphereSet, DropsNonFiniteParticlesWithTheirRadii) {
  const ParticleSet set = with_radii({{0, 0, 0}, {kNaN, 0, 0}, {4, 0, 0}}, "pscale", {1, 7, 3});
  EXPECT_EQ(make_spheres(set, spheres(), Context()).error().hint,
            Hint(Remedy::set, Setting::nan_policy, "outside to leave such particles out"));
  FieldOptions skip = spheres();
  skip.non_finite = NonFiniteParticles::skip;
  const Context context;
  {
    const auto kept = make_spheres(set, skip, context);
    ASSERT_TRUE(kept);
    EXPECT_EQ(kept->figures().particles, 2U);
    EXPECT_EQ(kept->figures().particles_dropped, 1U);
    ASSERT_EQ(kept->particles().size(), 2U);
    EXPECT_EQ(kept->particles().positions[1], glm::dvec3(4, 0, 0));
    EXPECT_EQ(kept->radii()[1], 3);
    EXPECT_GT(context.memory().reserved(), 0U);
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
  const auto none = make_spheres(with_radii({{kNaN, 0, 0}}, "pscale", {1}), skip, Context());
  ASSERT_TRUE(none);
  EXPECT_EQ(none->particles().size(), 0U);
}

TEST(SphereSet, RejectsInvalidRadii) {
  for (const float radius : {-1.0F, static_cast<float>(kNaN), std::numeric_limits<float>::infinity()}) {
    const auto refused = make_spheres(with_radii({{0, 0, 0}, {1, 0, 0}}, "pscale", {1, radius}), spheres(), Context());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::input);
    EXPECT_NE(refused.error().message.find("in the attribute 'pscale'"), std::string::npos) << refused.error().message;
  }
  // All particles have radius 0, which gives no spacing.
  const auto zero = make_spheres(with_radii({{0, 0, 0}, {1, 0, 0}}, "pscale", {0, 0}), spheres(), Context());
  ASSERT_FALSE(zero);
  EXPECT_NE(zero.error().message.find("median above 0 in the attribute 'pscale'"), std::string::npos)
      << zero.error().message;
}

SphereSpacings spacings_of(const std::vector<float>& radii) {
  std::vector<glm::dvec3> positions;
  for (std::size_t i = 0; i < radii.size(); ++i) positions.emplace_back(3.0 * static_cast<double>(i), 0, 0);
  const auto found = find_sphere_spacings(with_radii(positions, "pscale", radii), spheres(), Context());
  if (!found || !*found) {
    ADD_FAILURE() << "expected spacings";
    return {};
  }
  return **found;
}

TEST(SphereSet, FindsTheSpacingsThatKeepSmallSpheres) {
  const SphereSpacings even = spacings_of({1, 1, 2});
  EXPECT_EQ(even.usual, 0.5);
  EXPECT_NEAR(even.keeps_all, 1 / 1.5, 1e-8);
  EXPECT_EQ(even.keeps_most, 0.5) << "never above the usual one";
  const SphereSpacings small = spacings_of({1, 1, 0.3F, 0, 2});
  EXPECT_NEAR(small.keeps_all, 0.2, 1e-8) << "a radius of 0 needs no samples";
  EXPECT_EQ(small.keeps_most, small.keeps_all);
  EXPECT_GE(static_cast<double>(0.3F), kMinSphereRadius * small.keeps_all);
  // 4 times finer is 0.125, which keeps a radius of 0.1875.
  const SphereSpacings limit = spacings_of({1, 1, 1, 1, 0.1875F, 0.1874F, 1e-6F});
  EXPECT_NEAR(limit.keeps_most, 0.125, 1e-8);
  EXPECT_LT(limit.keeps_all, 1e-6);
  const SphereSpacings stray = spacings_of({1, 1, 1, 1, 1e-6F});
  EXPECT_EQ(stray.keeps_most, 0.5) << "one that cannot be kept refines nothing";
}

TEST(SphereSet, FindsNoSpacingsForOneRadius) {
  const ParticleSet set = with_radii({{0, 0, 0}, {3, 0, 0}}, "pscale", {1, 0.1F});
  FieldOptions given = spheres();
  given.radius = 1;
  EXPECT_FALSE(find_sphere_spacings(set, given, Context()).value());
  EXPECT_FALSE(find_sphere_spacings(particles_at({{0, 0, 0}, {3, 0, 0}}), spheres(), Context()).value());
  EXPECT_FALSE(find_sphere_spacings(with_radii({{0, 0, 0}}, "pscale", {0}), spheres(), Context()).value());
  EXPECT_FALSE(find_sphere_spacings(with_radii({{0, 0, 0}}, "pscale", {-1}), spheres(), Context()));
}

TEST(SphereSet, IsRejectedByMakeField) {
  const auto refused = make_field(particles_at({{0, 0, 0}, {1, 0, 0}}), spheres(), Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace isoextract::points

#include "points/region.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "base/finite.hpp"
#include "base/reserved_buffer.hpp"
#include "points/detail/anisotropy.hpp"
#include "points/detail/box_samples.hpp"
#include "points/detail/field_lengths.hpp"
#include "points/detail/particle_radii.hpp"
#include "points/detail/periodic_images.hpp"
#include "points/selection.hpp"

namespace isoextract::points {
namespace {

// Samples beyond the region and FieldOptions::margin: those of the cells that cover it, the margin of an extraction,
// and the narrow band of a level set.
constexpr int kMoreSamples = 2 + kPeriodicMargin + 3;
// Longest step of samples in a periodic box, in spacings: 4 cells divide an edge of up to 4.5 spacings.
constexpr double kLongestStep = 1.125;

// Tests positions in the coordinates in which the region is a box: the world, or fractions of a periodic box.
class RegionTest {
 public:
  // Returns nullopt if the region does not meet the periodic box.
  [[nodiscard]] static std::optional<RegionTest> make(const ParticleSet& particles, const field::Box& region) {
    RegionTest test;
    test.box_ = region;
    if (!(particles.box && particles.box->is_periodic())) return test;
    test.map_ = particles.box->world_from_fractions().inverse();
    test.periodic_ = particles.box->periodic;
    test.box_ = field::image_of(test.map_, region);
    for (int k = 0; k < 3; ++k) {
      if (!test.is_periodic(k)) continue;
      test.box_.min[k] = std::max(test.box_.min[k], 0.0);
      test.box_.max[k] = std::min(test.box_.max[k], 1.0);
      if (!(test.box_.min[k] < test.box_.max[k])) return std::nullopt;
    }
    return test;
  }

  // Returns the test of the region with all that lies at most `reach` world units outside of it.
  [[nodiscard]] RegionTest grown(double reach) const {
    RegionTest larger = *this;
    const glm::dmat3 rows = glm::transpose(map_.linear);
    const glm::dvec3 extent = reach * glm::dvec3(glm::length(rows[0]), glm::length(rows[1]), glm::length(rows[2]));
    larger.box_ = {box_.min - extent, box_.max + extent};
    return larger;
  }

  [[nodiscard]] bool has(const glm::dvec3& position) const {
    if (!is_finite(position)) return true;
    glm::dvec3 p = map_(position);
    for (int k = 0; k < 3; ++k) {
      if (is_periodic(k)) p[k] -= std::floor(p[k] - box_.min[k]);  // the first image above the lower face
    }
    return glm::all(glm::lessThanEqual(box_.min, p)) && glm::all(glm::lessThanEqual(p, box_.max));
  }

 private:
  [[nodiscard]] bool is_periodic(int k) const { return periodic_[static_cast<std::size_t>(k)]; }

  field::Affine map_;
  field::Box box_;
  std::array<bool, 3> periodic_{false, false, false};
};

using Indices = std::shared_ptr<ReservedBuffer<std::uint32_t>>;

template <class Test>
Result<Indices> indices_where(const ParticleSet& particles, const Test& is_chosen, const Context& context) {
  const auto count = static_cast<std::size_t>(std::ranges::count_if(particles.positions, is_chosen));
  auto indices = make_reserved_buffer<std::uint32_t>(count, context, particles.label + ": particles in a region");
  if (!indices) return indices;
  std::size_t next = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (is_chosen(particles.positions[i])) (*indices)->values[next++] = static_cast<std::uint32_t>(i);
  }
  return indices;
}

// Keeps the particles at chosen positions; returns how many it removed.
template <class Test>
Result<std::uint64_t> keep_where(ParticleSet& particles, const Test& is_chosen, const Context& context) {
  const auto indices = TRY(indices_where(particles, is_chosen, context));
  const std::uint64_t removed = particles.size() - indices->values.size();
  if (removed > 0) particles = TRY(take_particles(particles, std::as_const(indices->values).span(), context));
  return removed;
}

// Sets the radius from the particles. Returns whether they give one.
Result<bool> set_radius_of(const ParticleSet& particles, FieldOptions& options, const Context& context) {
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  if (bounds.finite == 0) return false;
  if (const auto radii = TRY(find_radii(particles, options, bounds, context))) {
    options.median_radius = radii->median;
    return true;
  }
  options.suggested_radius = TRY(suggest_radius(particles, context));
  return options.suggested_radius.has_value();
}

// Sets the radius as keep_region() promises.
Result<void> set_radius(const ParticleSet& particles, const RegionTest& test, FieldOptions& options,
                        const Context& context) {
  if (options.radius || (options.suggested_radius && radius_attribute(particles) == nullptr)) return {};
  const auto is_inside = [&](const glm::dvec3& position) { return test.has(position); };
  const auto indices = TRY(indices_where(particles, is_inside, context));
  const auto inside = TRY(take_particles(particles, std::as_const(indices->values).span(), context));
  for (const ParticleSet* set : {&inside, &particles}) {
    if (TRY(set_radius_of(*set, options, context))) break;
  }
  return {};
}

// Returns the largest distance, in world units, between a sample and a particle that affects it. `largest` is the
// radius of the largest particle.
double reach_of_sample(const FieldOptions& options, const ParticleFieldStatistics& figures, double largest) {
  switch (options.method) {
    case Method::weight: return std::sqrt(3.0) * kLongestStep * figures.spacing;
    // Twice a support: of the kernels, and of the neighbors that determine their densities.
    case Method::sph: return 2 * figures.support * std::max(1.0, largest / figures.radius);
    case Method::anisotropic:
      return figures.spacing * anisotropic_reach(options.anisotropy, figures.support / figures.spacing);
    case Method::spheres: return largest;
    case Method::smooth: break;
  }
  return largest + 2 * figures.support;
}

}  // namespace

Result<std::uint64_t> keep_inside(ParticleSet& particles, const field::Box& region, const Context& context) {
  const auto test = RegionTest::make(particles, region);
  if (!test) return 0;
  return keep_where(
      particles, [&](const glm::dvec3& position) { return test->has(position); }, context);
}

Result<std::uint64_t> keep_finite(ParticleSet& particles, NonFiniteParticles bad, const Context& context) {
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  TRY(check_positions(particles, bounds, bad));
  if (bounds.not_finite == 0) return 0;
  return keep_where(
      particles, [](const glm::dvec3& position) { return is_finite(position); }, context);
}

Result<std::uint64_t> keep_region(ParticleSet& particles, const field::Box& region, FieldOptions& options,
                                  const Context& context) {
  TRY(check_options(options));
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  TRY(check_positions(particles, bounds, options.non_finite));
  const auto test = RegionTest::make(particles, region);
  if (!test || bounds.finite == 0) return 0;
  const auto radii = TRY(find_radii(particles, options, bounds, context));
  TRY(set_radius(particles, *test, options, context));

  ParticleFieldStatistics figures;
  figures.particles = bounds.finite;
  if (radii) {
    figures.radius = options.median_radius.value_or(radii->median);
    figures.radius_attribute = radii->attribute->name;
  }
  TRY(resolve_lengths(particles, options, figures, context));
  const double largest = std::max(radii ? radii->max : 0, figures.radius);
  double spacing = figures.spacing;
  const bool is_level_set = method_info(options.method).kind == field::FieldKind::level_set;
  if (is_level_set && particles.box && particles.box->is_periodic()) {
    spacing = common_spacing(*particles.box, spacing).value_or(spacing);
  }
  const double attribute_reach = 4 * options.smoothing_length * figures.radius;
  const double reach = std::max(reach_of_sample(options, figures, largest), attribute_reach) +
                       (kMoreSamples + options.margin) * kLongestStep * spacing;
  const RegionTest larger = test->grown(reach);
  return keep_where(
      particles, [&](const glm::dvec3& position) { return larger.has(position); }, context);
}

}  // namespace isoextract::points

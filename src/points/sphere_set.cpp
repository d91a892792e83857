#include "points/sphere_set.hpp"

#include <algorithm>
#include <utility>

#include "base/finite.hpp"
#include "points/detail/field_lengths.hpp"
#include "points/detail/particle_radii.hpp"

namespace isoextract::points {
namespace {

// Returns the radii of the particles at finite positions.
Result<std::shared_ptr<ReservedBuffer<float>>> radii_of(const ParticleSet& particles, const ParticleAttribute& radii,
                                                        std::uint64_t finite, const Context& context) {
  auto kept = make_reserved_buffer<float>(finite, context, particles.label + ": radii of particles");
  if (!kept) return kept;
  std::size_t n = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (is_finite(particles.positions[i])) (*kept)->values[n++] = radii.values[i];
  }
  return kept;
}

Result<std::shared_ptr<const ParticleSet>> finite_ones(const ParticleSet& particles, std::uint64_t finite,
                                                       const Context& context) {
  auto memory = TRY(context.reserve(finite * sizeof(glm::dvec3), particles.label + ": positions of particles"));
  auto kept = std::make_shared<ParticleSet>();
  kept->label = particles.label;
  kept->positions = Buffer<glm::dvec3>(finite);
  kept->memory = std::move(memory);
  std::copy_if(particles.positions.begin(), particles.positions.end(), kept->positions.begin(),
               [](const glm::dvec3& p) { return is_finite(p); });
  return kept;
}

}  // namespace

bool has_radius_attribute(const ParticleSet& particles) { return radius_attribute(particles) != nullptr; }

Result<SphereSet> make_spheres(const ParticleSet& particles, const FieldOptions& options, const Context& context) {
  TRY(check_options(options));
  const ParticleBounds bounds = measure_bounds(particles.positions.span());
  TRY(check_positions(particles, bounds, options.bad));
  SphereSet spheres(particles);
  ParticleFieldStatistics& figures = spheres.figures_;
  figures.particles = bounds.finite;
  figures.particles_dropped = bounds.not_finite;
  if (bounds.not_finite > 0) {
    spheres.kept_ = TRY(finite_ones(particles, bounds.finite, context));
  }
  if (bounds.finite == 0) return spheres;
  if (const auto found = TRY(find_radii(particles, options, bounds, context))) {
    auto radii = TRY(radii_of(particles, *found->attribute, bounds.finite, context));
    figures.radius = found->median;
    figures.radius_attribute = found->attribute->name;
    spheres.radii_ = radii->values.span();
    spheres.kept_radii_ = std::move(radii);
  }
  TRY(resolve_lengths(particles, options, figures, context));
  return spheres;
}

}  // namespace isoextract::points

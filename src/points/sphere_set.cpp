#include "points/sphere_set.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/printable.hpp"
#include "points/detail/field_lengths.hpp"

namespace isoextract::points {
namespace {

const ParticleAttribute* radius_attribute(const ParticleSet& particles) {
  for (const std::string_view name : kRadiusAttributes) {
    for (const ParticleAttribute& attribute : particles.attributes) {
      if (attribute.name == name && attribute.components == 1) return &attribute;
    }
  }
  return nullptr;
}

Result<std::shared_ptr<ReservedBuffer<float>>> radii_at(const ParticleSet& particles, const ParticleAttribute& radii,
                                                        std::uint64_t finite, const Context& context) {
  auto kept = make_reserved_buffer<float>(finite, context, particles.label + ": radii of particles");
  if (!kept) return kept;
  std::size_t n = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!is_finite(particles.positions[i])) continue;
    const float radius = radii.values[i];
    if (!(std::isfinite(radius) && radius >= 0)) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected finite radii of 0 or more in the attribute '{}', found {} at particle {}",
                              particles.label, printable(radii.name), radius, i),
                  {Remedy::give, Setting::radius});
    }
    (*kept)->values[n++] = radius;
  }
  return kept;
}

Result<double> median_of(std::span<const float> radii, const ParticleSet& particles, const Context& context) {
  const auto sorted = TRY(make_reserved_buffer<float>(radii.size(), context, particles.label + ": radii of particles"));
  std::ranges::copy(radii, sorted->values.begin());
  float* const middle = sorted->values.begin() + radii.size() / 2;
  std::nth_element(sorted->values.begin(), middle, sorted->values.end());
  return static_cast<double>(*middle);
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
  if (const ParticleAttribute* attribute = options.radius ? nullptr : radius_attribute(particles)) {
    auto radii = TRY(radii_at(particles, *attribute, bounds.finite, context));
    figures.radius = TRY(median_of(radii->values.span(), particles, context));
    figures.radius_attribute = attribute->name;
    spheres.radii_ = radii->values.span();
    spheres.kept_radii_ = std::move(radii);
  }
  TRY(resolve_lengths(particles, options, figures, context));
  return spheres;
}

}  // namespace isoextract::points

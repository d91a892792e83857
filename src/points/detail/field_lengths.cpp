#include "points/detail/field_lengths.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "base/printable.hpp"

namespace isoextract::points {

Result<void> check_positions(const ParticleSet& particles, const ParticleBounds& bounds, NonFiniteParticles bad) {
  if (particles.size() > std::numeric_limits<std::uint32_t>::max()) {
    return fail(ErrorCode::input, fmt::format("{}: expected at most {} particles, found {}", particles.label,
                                              std::numeric_limits<std::uint32_t>::max(), particles.size()));
  }
  if (!bounds.first_broken || bad == NonFiniteParticles::skip) return {};
  const glm::dvec3& p = particles.positions[*bounds.first_broken];
  return fail(ErrorCode::input,
              fmt::format("{}: expected finite positions, found ({}, {}, {}) at particle {}", particles.label, p.x, p.y,
                          p.z, *bounds.first_broken),
              {Remedy::set, Setting::nan_policy, "outside to leave such particles out"});
}

Result<void> resolve_lengths(const ParticleSet& particles, const FieldOptions& options,
                             ParticleFieldStatistics& figures, const Context& context) {
  if (options.radius) {
    figures.radius = *options.radius;
  } else if (figures.radius_attribute.empty()) {
    std::optional<double> radius = options.suggested_radius;
    if (!radius) radius = TRY(suggest_radius(particles, context));
    if (!radius) {
      return fail(
          ErrorCode::input,
          fmt::format("{}: expected a particle radius, or particles at two or more positions to derive the radius "
                      "from; found {} particles at one position",
                      particles.label, figures.particles),
          {Remedy::give, Setting::radius});
    }
    figures.radius = *radius;
    figures.radius_suggested = true;
  }
  figures.spacing =
      options.spacing.value_or(options.cell_size.value_or(method_info(options.method).cell_size) * figures.radius);
  if (figures.radius == 0 && figures.spacing == 0 && !figures.radius_attribute.empty()) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected radii with a median above 0 in the attribute '{}', found a median of 0",
                            particles.label, printable(figures.radius_attribute, 80)),
                {Remedy::give, Setting::radius});
  }
  const bool of_kernels = has_kernels(options.method);
  if (of_kernels) figures.support = 2 * options.smoothing_length * figures.radius;
  if (!(figures.spacing > 0) || !std::isfinite(figures.spacing)) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a finite sample spacing above 0, found {} (the particle radius is {})",
                            particles.label, figures.spacing, figures.radius));
  }
  if (!std::isfinite(figures.support)) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected a finite reach of the kernels, found {} (the particle radius is {})",
                            particles.label, figures.support, figures.radius));
  }
  // With a larger spacing, particles between samples would have no effect.
  if (of_kernels && !(figures.support >= figures.spacing)) {
    return fail(
        ErrorCode::usage,
        fmt::format("{}: expected a sample spacing of at most the reach of a kernel, {:.6g}; found a spacing of "
                    "{:.6g}",
                    particles.label, figures.support, figures.spacing),
        {Remedy::lower, Setting::cell_size});
  }
  return {};
}

}  // namespace isoextract::points

#include "points/detail/field_lengths.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace isoextract::points {

Result<void> check_coordinate_rounding(const ParticleSet& particles, const ParticleBounds& bounds,
                                       NonFiniteParticles bad) {
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
    auto statistics = TRY(measure_statistics(particles, context));
    const std::optional<double> radius = statistics.suggested_radius();
    if (!radius) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected particles at two places at least, to take their radius from, or a radius; "
                              "found {} at one place",
                              particles.label, statistics.bounds.finite),
                  {Remedy::give, Setting::radius});
    }
    figures.radius = *radius;
    figures.radius_suggested = true;
  }
  figures.spacing =
      options.spacing.value_or(options.cell_size.value_or(method_info(options.method).cell_size) * figures.radius);
  const bool has_kernels = options.method != Method::weight && options.method != Method::spheres;
  if (has_kernels) figures.support = 2 * options.smoothing_length * figures.radius;
  if (!(figures.spacing > 0) || !std::isfinite(figures.spacing) || !std::isfinite(figures.support)) {
    return fail(ErrorCode::input, fmt::format("{}: a particle radius of {} leaves the range of numbers",
                                              particles.label, figures.radius));
  }
  // Otherwise particles between samples would have no effect.
  if (has_kernels && !(figures.support >= figures.spacing)) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected samples at most as far apart as a kernel reaches, {:.6g}; found a spacing of "
                            "{:.6g}",
                            particles.label, figures.support, figures.spacing),
                {{Remedy::lower, Setting::cell_size}, {Remedy::raise, Setting::radius}});
  }
  return {};
}

}  // namespace isoextract::points

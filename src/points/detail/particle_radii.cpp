#include "points/detail/particle_radii.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/finite.hpp"
#include "base/printable.hpp"
#include "base/reserved_buffer.hpp"
#include "points/sphere_set.hpp"

namespace isoextract::points {

const ParticleAttribute* radius_attribute(const ParticleSet& particles) {
  for (const std::string_view name : kRadiusAttributes) {
    for (const ParticleAttribute& attribute : particles.attributes) {
      if (attribute.name == name && attribute.components == 1) return &attribute;
    }
  }
  return nullptr;
}

Result<std::optional<ParticleRadii>> find_radii(const ParticleSet& particles, const FieldOptions& options,
                                                const ParticleBounds& bounds, const Context& context) {
  const ParticleAttribute* const attribute = options.radius ? nullptr : radius_attribute(particles);
  if (attribute == nullptr || bounds.finite == 0) return std::nullopt;
  const auto sorted =
      TRY(make_reserved_buffer<float>(bounds.finite, context, particles.label + ": radii of particles"));
  std::size_t n = 0;
  for (std::size_t i = 0; i < particles.size(); ++i) {
    if (!is_finite(particles.positions[i])) continue;
    const float radius = attribute->values[i];
    if (!(std::isfinite(radius) && radius >= 0)) {
      return fail(ErrorCode::input,
                  fmt::format("{}: expected finite radii of 0 or more in the attribute '{}', found {} at particle {}",
                              particles.label, printable(attribute->name), radius, i),
                  {Remedy::give, Setting::radius});
    }
    sorted->values[n++] = radius;
  }
  float* const middle = sorted->values.begin() + n / 2;
  std::nth_element(sorted->values.begin(), middle, sorted->values.begin() + n);
  const auto [least, most] = std::minmax_element(sorted->values.begin(), sorted->values.begin() + n);
  return ParticleRadii{attribute, options.median_radius.value_or(static_cast<double>(*middle)),
                       static_cast<double>(*least), static_cast<double>(*most)};
}

}  // namespace isoextract::points

// The radii of particles, from one of their attributes.
#pragma once

#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_field.hpp"
#include "points/particle_set.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {

struct ParticleRadii {
  const ParticleAttribute* attribute = nullptr;  // one value per particle; valid for particles at finite positions
  double median = 0;                             // of the particles at finite positions, or FieldOptions::median_radius
  double min = 0;
  double max = 0;
};

// Returns the attribute with the radii (kRadiusAttributes), or null.
[[nodiscard]] const ParticleAttribute* radius_attribute(const ParticleSet& particles);

// Returns the radii, or nothing if FieldOptions::radius is set, or if no particle is at a finite position, or if the
// particles have no radius attribute. Fails with ErrorCode::input if a particle at a finite position has a radius that
// is negative or not finite, and as Context::reserve() does.
[[nodiscard]] Result<std::optional<ParticleRadii>> find_radii(const ParticleSet& particles, const FieldOptions& options,
                                                              const ParticleBounds& bounds, const Context& context);

}  // namespace isoextract::points

// What has to be known of particles before they become a field, whatever the method.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_field.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {

// Fails with ErrorCode::input where there are too many particles to be numbered, or where a position is not finite and
// that is an error. `bounds` is of the particles.
[[nodiscard]] Result<void> check_places(const ParticleSet& particles, const ParticleBounds& bounds, BadParticles bad);

// Puts radius, spacing and support into `figures`, as FieldOptions says them. Where an attribute has given the radii
// (FieldFigures::radius_attribute), the radius is there already. At least one position is finite.
[[nodiscard]] Result<void> settle_lengths(const ParticleSet& particles, const FieldOptions& options,
                                          FieldFigures& figures, const Context& context);

}  // namespace isoextract::points

// Checks and lengths needed before particles become a field, for every method.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_field.hpp"
#include "points/particle_statistics.hpp"

namespace isoextract::points {

// Fails with ErrorCode::input if there are too many particles for 32-bit indices, or if a position is not finite and
// `bad` is NonFiniteParticles::error. `bounds` are the bounds of `particles`.
[[nodiscard]] Result<void> check_positions(const ParticleSet& particles, const ParticleBounds& bounds,
                                           NonFiniteParticles bad);

// Sets radius, spacing and support of `figures` from the options. Keeps a radius from an attribute (radius_attribute
// is set) unless FieldOptions::radius is set. Requires at least one finite position. Fails with ErrorCode::input if no
// radius is known, the spacing is 0 or a length is not finite, with ErrorCode::usage if the spacing exceeds the
// support.
[[nodiscard]] Result<void> resolve_lengths(const ParticleSet& particles, const FieldOptions& options,
                                           ParticleFieldStatistics& figures, const Context& context);

}  // namespace isoextract::points

// From particles to the field that is extracted, by the method that was asked for.
#pragma once

#include <optional>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

// By points::make_field() or, for level sets, volume_io::spheres_to_field(); fails as these do. `only_iso` is
// FieldOptions::leave_out_inside. Where particles are too small for their spheres to be sampled, that is told in the
// field's notes, and ErrorCode::input where all of them are.
[[nodiscard]] Result<points::ParticleField> make_particle_field(const points::ParticleSet& particles,
                                                                const ParticleOptions& options,
                                                                std::optional<double> only_iso, const Context& context);

}  // namespace isoextract::convert

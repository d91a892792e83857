// Makes the field to extract from particles, by the chosen method.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

enum class Positions { keep, free };

// Makes the field by points::make_field() or, for level sets, by points::make_spheres() and
// volume_io::rasterize_spheres(); fails as they do. Level sets ignore FieldOptions::tile_iso and FieldOptions::margin.
//
// For level sets, leaves out and counts spheres too small to be sampled (ParticleFieldStatistics::particles_too_small),
// and fails with ErrorCode::input if all are too small.
//
// With Positions::free, the positions of the particles may be gone afterwards; see points::make_field_and_free().
[[nodiscard]] Result<points::ParticleField> make_particle_field(points::ParticleSet& particles, Positions positions,
                                                                const points::FieldOptions& options,
                                                                const Context& context);

}  // namespace isoextract::convert

// Makes the field to extract from particles, by the chosen method.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "points/particle_field.hpp"

namespace isoextract::convert {

// The spacing of the samples for spheres of unlike radii.
struct SphereSpacing {
  // In world units. Unset if the options give the cell size, if the field is resampled, or if the particles have no
  // radii of their own.
  std::optional<double> spacing;
  Notes notes;  // about finer samples than usual, and about particles that the surface will leave out
};

// Chooses the spacing for spheres with radii from an attribute: fine enough to keep the smallest spheres, but at most
// points::kMaxSphereRefinement times finer than usual, and within a quarter of the memory limit. Keeps the usual
// spacing if the field is resampled, and takes ParticleOptions::sequence_spacing if that is set. Chooses nothing for
// methods without spheres. Fails as points::make_spheres() and volume_io::sphere_bytes() do.
[[nodiscard]] Result<SphereSpacing> choose_sphere_spacing(const points::ParticleSet& particles,
                                                          const SourceOptions& source, const Context& context);

enum class Positions { keep, free };

// Makes the field by points::make_field() or, for level sets, by points::make_spheres() and
// volume_io::rasterize_spheres(); fails as they do. Level sets ignore FieldOptions::tile_iso.
//
// For level sets, leaves out and counts spheres too small to be sampled (ParticleFieldStatistics::particles_too_small),
// and fails with ErrorCode::input if all are too small.
//
// With Positions::free, the positions of the particles may be gone afterwards; see points::make_field_and_free().
[[nodiscard]] Result<points::ParticleField> make_particle_field(points::ParticleSet& particles, Positions positions,
                                                                const points::FieldOptions& options,
                                                                const Context& context);

}  // namespace isoextract::convert

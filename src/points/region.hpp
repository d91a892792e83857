// Removes the particles that do not affect a region of their field.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "points/particle_field.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// `region` is in world units. In a periodic box, the region ends at the periodic faces, and a particle is inside if one
// of its images is. In a box that is not upright, the smallest parallelepiped around the region, along the box's edges,
// replaces the region. Particles at non-finite positions are in every region, so that FieldOptions::non_finite applies.

// keep_inside() and keep_region() return how many particles they removed, and remove none if the region does not meet
// the periodic box.

// Removes the particles outside the region. Fails as take_particles() does.
[[nodiscard]] Result<std::uint64_t> keep_inside(ParticleSet& particles, const field::Box& region,
                                                const Context& context);

// Removes the particles whose position is not finite, or fails if `bad` is NonFiniteParticles::error. Returns how many
// it removed.
[[nodiscard]] Result<std::uint64_t> keep_finite(ParticleSet& particles, NonFiniteParticles bad, const Context& context);

// Keeps the particles that affect the field in the region, or the attributes of a surface there (sample_attributes()
// with FieldOptions::smoothing_length). Removes all other particles. The samples in the region stay the same apart from
// rounding, and so do the samples next to it that an extraction and FieldOptions::margin need.
//
// Also fixes the radius in `options`, so that the remaining particles give the field of all: sets median_radius if an
// attribute gives the radii, else suggested_radius unless it is set. Takes the radius from the particles inside the
// region, or from all particles if they give none. Leaves `options` unchanged if FieldOptions::radius is set.
//
// Fails as make_field() and make_spheres() do.
[[nodiscard]] Result<std::uint64_t> keep_region(ParticleSet& particles, const field::Box& region, FieldOptions& options,
                                                const Context& context);

}  // namespace isoextract::points

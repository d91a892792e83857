// Restricts particles to those that a region of their field depends on.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/affine.hpp"
#include "points/particle_field.hpp"
#include "points/particle_set.hpp"

namespace isoextract::points {

// `region` is in world units. In a periodic box, a particle lies in the part of the region within the box if one of its
// images does. In a box that is not upright, the smallest parallelepiped around that part, along the edges of the box,
// stands for it. Particles whose position is not finite belong to every region, so that FieldOptions::bad applies.

// Both return how many particles they removed, and remove none if the region does not meet the periodic box.

// Removes the particles outside the region. Fails as take_particles() does.
[[nodiscard]] Result<std::uint64_t> keep_inside(ParticleSet& particles, const field::Box& region,
                                                const Context& context);

// Removes the particles whose position is not finite, or fails if `bad` is NonFiniteParticles::error. Returns how many
// it removed.
[[nodiscard]] Result<std::uint64_t> keep_finite(ParticleSet& particles, NonFiniteParticles bad, const Context& context);

// Removes the particles that neither the field in the region depends on, nor the attributes of a surface there
// (sample_attributes() with FieldOptions::smoothing_length). Samples of the region, and those next to it that an
// extraction and FieldOptions::margin need, stay the same apart from rounding.
//
// Sets the lengths of `options` so that the particles left have the field of all. The radius is the one that suggests
// itself for the particles inside the region; from an attribute, it is the median of their radii. If they give no
// radius, all particles give it.
//
// Fails as make_field() and make_spheres() do.
[[nodiscard]] Result<std::uint64_t> keep_region(ParticleSet& particles, const field::Box& region, FieldOptions& options,
                                                const Context& context);

}  // namespace isoextract::points

// Chooses particles by a condition on their attributes and positions.
//
// Numbers are compared as float64. Attributes are float32. If an attribute without arithmetic is compared with a number
// literal, the literal is rounded to float32 first, so that `T == 0.1` finds values that the file states as 0.1.
// A comparison with NaN is false, also `!=` and `in`. Words are compared byte by byte.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/reserved_buffer.hpp"
#include "points/particle_set.hpp"
#include "points/selection_expression.hpp"

namespace isoextract::points {

// Returns the indices of the particles that fulfill the condition, in ascending order; the same for any number of
// threads. A set without particles needs no attributes.
//
// Fails with ErrorCode::input if an attribute does not exist, has the wrong number of components, or holds words where
// the condition needs numbers or the reverse; the hint marks the place in the condition. Also fails with
// ErrorCode::input for 2^32 particles or more, and as Context::reserve() and Context::check() do.
[[nodiscard]] Result<std::shared_ptr<ReservedBuffer<std::uint32_t>>> choose_particles(
    const ParticleSet& particles, const SelectionExpression& condition, const Context& context);

// Returns the particles at these indices, in this order, with all attributes, and all columns of words except columns
// marked too_many. Fails as Context::reserve() does.
[[nodiscard]] Result<ParticleSet> take_particles(const ParticleSet& particles, std::span<const std::uint32_t> indices,
                                                 const Context& context);

}  // namespace isoextract::points

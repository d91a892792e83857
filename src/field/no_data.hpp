// No-data values: numbers that a file writes where it has no measurement.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Turns the samples of a dense field whose scaled value equals `value` into NaN. Adds a note with their number, or a
// note that no sample has the value.
// Compares in the samples' type, or in float if the value scale is not the identity.
//
// If there are such samples, the field gets new samples in reserved memory. Integers have no NaN, so they become f32,
// and those of 32 bits f64. Fails with ErrorCode::usage for sparse fields, with ErrorCode::out_of_memory if there is no
// memory for the new samples, and with ErrorCode::input if the file became unreadable while samples were copied.
[[nodiscard]] Result<void> mark_no_data(ScalarField& field, double value, const Context& context);

}  // namespace isoextract::field

// Values that files write where there are none.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Samples of dense `field` whose value, by its scale, is `value` become NaN, and a note tells how many. Equal is what
// rounds to the same number of the samples' type, or of float where the scale is not the identity. Where there is such
// a sample, they are in memory of their own after that, reserved before it is taken: integers, which have no NaN, as
// f32, and those of 32 bits as f64. Fails with ErrorCode::usage where the field is sparse, with ErrorCode::input where
// the memory is not there.
[[nodiscard]] Result<void> mark_no_data(ScalarField& field, double value, const Context& context);

}  // namespace isoextract::field

// Coarser versions of a field.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// One sample for each `factor`^3 (a power of two, 2 or more), their mean: a box filter. It stands at the centre of
// those samples. Dense stays dense, without the last samples of an axis where `factor` does not divide their number;
// sparse stays sparse, its blocks aligned with multiples of 8 * `factor`. Samples are f64 if they were, otherwise f32;
// a sample that is not finite makes the mean not finite. Fails with ErrorCode::input where an axis would have fewer
// than two samples, or the memory for it is not there.
[[nodiscard]] Result<ScalarField> coarsen(const ScalarField& field, int factor, const Context& context);

}  // namespace isoextract::field

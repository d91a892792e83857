// Coarser versions of a field.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Replaces each factor^3 samples by their mean (a box filter), placed at their center. `factor` is a power of two, at
// least 2. The result is f64 for f64 samples, else f32; a mean that includes a sample that is not finite is not finite.
//
// Dense fields stay dense and lose the last samples of an axis if `factor` does not divide their number. Sparse fields
// stay sparse, with blocks aligned to multiples of 8 * `factor` samples; `active_voxels` is then divided by factor^3,
// an estimate. Fails with ErrorCode::input if an axis of dense samples would have fewer than two samples, with
// ErrorCode::out_of_memory, and as Context::check() does.
[[nodiscard]] Result<ScalarField> coarsen(const ScalarField& field, int factor, const Context& context);

}  // namespace isoextract::field

// A field as a plain array of values, for files that hold nothing else.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Returns `field` with dense samples of `type`, which is its own type or a floating-point type, and without a value
// scale (which needs a floating-point type). Sparse samples become dense in resampled_box(); `index_to_world` and
// `index_to_file` follow, and a note tells the size. Shares dense samples that need no change. A value that `type` does
// not hold is rounded; the caller ensures that it is in the range of `type`. The notes of the result are those of this
// function only.
//
// Reserves the memory of new samples in the context. Fails with ErrorCode::out_of_memory, with ErrorCode::input if the
// box has 2^31 or more samples along an axis, and as Context::check() does.
[[nodiscard]] Result<ScalarField> as_dense(const ScalarField& field, SampleType type, const Context& context);

}  // namespace isoextract::field

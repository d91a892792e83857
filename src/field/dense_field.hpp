// A field as a plain array of values, for files that hold nothing else.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

// Returns `field` with dense samples of `type` and without a value scale. `type` is the type of the field's own samples
// or a floating-point type; a field with a value scale needs a floating-point type. Sparse samples become dense in
// resampled_box(); `index_to_world` and `index_to_file` are adjusted, and a note tells the size. Shares dense samples
// that need no change. Rounds values that `type` cannot represent; the caller ensures that they are in the range of
// `type`. The result has the notes of this function only.
//
// Reserves the memory of new samples in the context. Fails with ErrorCode::input if resampled_box() has 2^31 or more
// samples along an axis, or if the file of mapped samples became shorter, with ErrorCode::out_of_memory, and as
// Context::check() does.
[[nodiscard]] Result<ScalarField> as_dense(const ScalarField& field, SampleType type, const Context& context);

}  // namespace isoextract::field

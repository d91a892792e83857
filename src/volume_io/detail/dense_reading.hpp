// The samples of a dense file into a field: which of its volumes and components, mapped or read, as one number each.
#pragma once

#include <string>

#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/detail/dense_format.hpp"

namespace isoextract::volume_io {

// Mapped where the samples lie in the file as they are wanted; else read, into memory that is reserved for as long as
// they live. The length of a vector is computed from values as the file's scale makes them; it is f64 where the
// components are f64 or integers that float does not hold, and else f32. Fails with ErrorCode::input where the file is
// shorter than its header says, where no volume or component is chosen of several, where an integer of 64 bits is none
// that a double holds, unless it is options.no_data, and where set_frame() does.
[[nodiscard]] Result<field::ScalarField> read_dense(const files::InputFile& file, DenseFile dense, std::string name,
                                                    const ReadOptions& options);

}  // namespace isoextract::volume_io

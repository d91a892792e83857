// The headers of files with dense samples, after which these come as they lie in memory.
#pragma once

#include <string>

#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

// As npy_text.hpp has it, [z, y, x] or [y, x].
[[nodiscard]] std::string npy_header(const field::DenseSamples& samples);

// With space directions and origin, so version 4 (http://teem.sourceforge.net/nrrd/format.html). Not for f16.
[[nodiscard]] std::string nrrd_header(const field::ScalarField& field, const field::DenseSamples& samples);

}  // namespace isoextract::volume_io

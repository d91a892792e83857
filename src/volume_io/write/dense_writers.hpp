// Headers of files with dense samples. The samples follow the header in the layout they have in memory.
#pragma once

#include <string>

#include "field/scalar_field.hpp"

namespace isoextract::volume_io {

// Returns the header of an array [z, y, x], or [y, x] for one layer; see npy_text.hpp.
[[nodiscard]] std::string npy_header(const field::DenseSamples& samples);

// Returns a header with space directions and origin, which need version 4
// (http://teem.sourceforge.net/nrrd/format.html). NRRD has no f16.
[[nodiscard]] std::string nrrd_header(const field::ScalarField& field, const field::DenseSamples& samples);

}  // namespace isoextract::volume_io

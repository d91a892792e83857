// The names that commands and messages use for a field and its file.
#pragma once

#include <string>

#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns "smoke.vdb[density]", or "head.nrrd" if the format has no grids. Always printable.
[[nodiscard]] std::string field_label(const field::ScalarField& field);

// Returns the file name without folder, packing (.gz) and extension.
[[nodiscard]] std::string stem_of_file(const std::string& input);

}  // namespace isoextract::convert

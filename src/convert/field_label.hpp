// The name that commands and messages use for a field.
#pragma once

#include <string>

#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns "smoke.vdb[density]", or "head.nrrd" if the format has no grids. Always printable.
[[nodiscard]] std::string field_label(const field::ScalarField& field);

}  // namespace isoextract::convert

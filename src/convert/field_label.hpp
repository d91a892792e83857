// What several commands call a field.
#pragma once

#include <string>

#include "field/scalar_field.hpp"

namespace isoextract::convert {

// "smoke.vdb[density]", or "head.nrrd" where the format has no grids; printable, whatever the names are.
[[nodiscard]] std::string field_label(const field::ScalarField& field);

}  // namespace isoextract::convert

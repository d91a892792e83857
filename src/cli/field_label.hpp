// Small facts that several commands show.
#pragma once

#include <cstdint>
#include <string>

#include "field/scalar_field.hpp"

namespace isoextract {

// "smoke.vdb[density]", or "head.nrrd" where the format has no grids.
[[nodiscard]] std::string field_label(const ScalarField& field);

// The most memory that this process has held so far, in bytes.
[[nodiscard]] std::uint64_t peak_memory();

}  // namespace isoextract

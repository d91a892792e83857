// The thickness and the grid of inner walls, for the stage and for the estimate of memory.
#pragma once

#include "convert/conversion_job.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Returns the cell side, in the mesh's units, of the grid that finds the inner wall: a quarter of the thickness, but at
// most the smallest spacing of the samples. For mesh files, only the thickness counts.
[[nodiscard]] double wall_cell(double thickness, const Source& source);

// Returns the thickness in the mesh's units, or 0 if its unit cannot be converted: for estimates, which do not fail.
[[nodiscard]] double thickness_or_zero(const HollowChoice& choice, const Source& source);

}  // namespace isoextract::convert

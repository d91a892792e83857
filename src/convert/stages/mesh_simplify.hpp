// Text of simplification settings, in the form of the command line.
#pragma once

#include <string>

#include "convert/surface_edits.hpp"

namespace isoextract::convert {

// Returns "100000" or "2.5%".
[[nodiscard]] std::string triangle_count_text(const TriangleCount& count);
// Returns "0.1voxel" or "0.5world".
[[nodiscard]] std::string simplify_bound_text(const SimplifyBound& bound);

}  // namespace isoextract::convert

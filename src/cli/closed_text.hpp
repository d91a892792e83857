// Describes whether the surfaces of a file are closed. Decides by the boundary edges if they were counted, otherwise by
// whether the extraction reached the data boundary.
#pragma once

#include <string>

#include "convert/conversion_job.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::cli {

// Returns "empty" (no triangles), "closed", or "open" with the location of the boundary and, for the data boundary and
// clip planes, the option that closes it. Replaces "closed" by "not manifold: ..." if readers of the file weld sheets
// that touch, or if an input mesh is not manifold; appends this text to "open". Adds the number of cells left out
// around NaN samples, and to "closed" the T-junctions of --t-junctions.
[[nodiscard]] std::string closed_or_open_text(const convert::WrittenOutput& output, const convert::ConversionJob& job);

}  // namespace isoextract::cli

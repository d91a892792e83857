// Describes whether the surfaces of a file are closed. Decides by the extraction and the cuts, or by counting boundary
// edges if these do not tell.
#pragma once

#include <string>

#include "convert/conversion_job.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::cli {

// Returns "not manifold: ..." if readers of the file weld sheets that touch. Else returns "empty" without
// triangles, "closed", or "open" with the location of the boundary and, for the data boundary and clip planes, the
// option that closes it. Adds the number of cells left out around NaN samples.
[[nodiscard]] std::string closed_or_open_text(const convert::WrittenOutput& output, const convert::ConversionJob& job);

}  // namespace isoextract::cli

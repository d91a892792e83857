// Describes whether the surfaces of a file are closed. Decides by the extraction and the cuts, or by counting boundary
// edges if these do not tell.
#pragma once

#include <string>

#include "convert/conversion_job.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::cli {

// Returns "closed", or "open" with the location of the boundary and the option that closes it.
[[nodiscard]] std::string closed_or_open_text(const convert::WrittenOutput& output, const convert::ConversionJob& job);

}  // namespace isoextract::cli

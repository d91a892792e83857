// Whether the surfaces of a file are closed, in words: from their extraction and cuts, and from a count of boundary
// edges where these leave it open.
#pragma once

#include <string>

#include "convert/conversion_job.hpp"
#include "convert/stage_report.hpp"

namespace isoextract::cli {

// "closed", or "open" with the places and the option that closes them.
[[nodiscard]] std::string ends_text(const convert::WrittenOutput& output, const convert::ConversionJob& job);

}  // namespace isoextract::cli

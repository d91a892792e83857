// Runs `isoextract` on the frames of a sequence, and reports and records the progress.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::frames if some frames failed; stderr has their errors by then. `arguments` are the words of the
// command line, for the manifest and the reports.
[[nodiscard]] Result<void> run_batch(const ConvertFlags& flags, const std::vector<std::string>& arguments);

}  // namespace isoextract::cli

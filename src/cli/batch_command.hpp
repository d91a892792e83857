// `isoextract` on the frames of a sequence: what a batch says and keeps while it runs.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// ErrorCode::frames where some frames failed; each of them was told on stderr. `arguments` are the words of the command
// line, for the manifest and the reports.
[[nodiscard]] Result<void> run_batch(const ConvertFlags& flags, const std::vector<std::string>& arguments);

}  // namespace isoextract::cli

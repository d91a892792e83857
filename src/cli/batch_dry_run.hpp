// Prints what a batch would do, for --dry-run.
#pragma once

#include "base/error.hpp"
#include "cli/batch_plan.hpp"
#include "cli/messages.hpp"

namespace isoextract::cli {

// Prints frames, files, gaps and an estimate of the memory to stdout. For the estimate it reads the first, the middle
// and the last of the frames whose input files are largest in bytes; frames of one file count as equally large. An
// estimate that fails becomes a note. Fails with the first error if all estimates fail, and with ErrorCode::output if
// stdout is not writable.
[[nodiscard]] Result<void> print_batch_plan(const BatchPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

// What a batch would do, where nothing is to be done.
#pragma once

#include "base/error.hpp"
#include "cli/batch_plan.hpp"
#include "cli/messages.hpp"

namespace isoextract::cli {

// Prints frames, files, gaps and an estimate of the memory to stdout. Reads some of the inputs for the estimate: the
// largest files, and of files of one size and frames of one file the first, the middle and the last. Fails where none
// of these can be estimated.
[[nodiscard]] Result<void> print_batch_plan(const BatchPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

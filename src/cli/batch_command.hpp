// Runs a batch: converts the frames of a sequence, and writes progress, manifest, tables and pages.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Plans and runs the batch. `arguments` are the words of the command line without the program's name, for the manifest,
// the reports and the page. Converts nothing with --dry-run.
//
// Fails with ErrorCode::frames if a frame failed, was cancelled or not started, or if frames are missing and
// BatchPlan::missing_is_error is set; stderr then has the errors of the frames. Fails as plan_batch(),
// check_batch_files(), find_sequence_values(), limit_threads(), agree() and write_pages() do, with ErrorCode::output if
// a file of the whole batch cannot be written, and with ErrorCode::unavailable if gnuplot is needed and missing.
[[nodiscard]] Result<void> run_batch(const ConvertFlags& flags, const std::vector<std::string>& arguments);

}  // namespace isoextract::cli

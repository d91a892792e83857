// Checks the output folders and files of a batch before the first frame.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/error.hpp"
#include "batch/frame_table.hpp"
#include "cli/batch_plan.hpp"
#include "files/input_file_set.hpp"

namespace isoextract::cli {

// Checks that the folders of all outputs of this run exist, or makes them if the plan allows it. Fails with
// ErrorCode::output.
[[nodiscard]] Result<void> make_folders(const BatchPlan& plan);

// Checks that no output replaces a file that the batch reads. Returns all files that the frames read, including those
// that only inputs refer to. Returns nullopt if no output exists yet and all output names are known, since then the
// batch replaces no file.
// Fails with ErrorCode::usage if an output is also an input, and as convert::check_output_file() for tables, plots and
// pages.
[[nodiscard]] Result<std::optional<files::InputFileSet>> check_batch_files(const BatchPlan& plan);

// Returns a sentence that lists the length units if frames with meshes have more than one unit; otherwise empty.
[[nodiscard]] std::string units_note(std::span<const batch::FrameRow> rows);

}  // namespace isoextract::cli

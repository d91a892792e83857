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

// Checks that the folders of the frames' outputs (of this shard) exist, or makes them if the plan allows it. Does not
// cover folders of reports, tables, plots and pages. Fails with ErrorCode::output.
[[nodiscard]] Result<void> make_folders(const BatchPlan& plan);

// Checks that no output replaces a file that the batch reads. Returns all files that the frames read, including data
// files that input headers name. Returns nullopt if the batch replaces no file: no output exists yet, no existing file
// has a name that a label may get, and no surface is split into bodies.
// Fails as batch::check_written_files() does, and as convert::check_output_file() for tables, plots and pages.
[[nodiscard]] Result<std::optional<files::InputFileSet>> check_batch_files(const BatchPlan& plan);

// Returns a note that lists the length units if the frames with surfaces have several ("unknown" counts as a unit);
// otherwise an empty text.
[[nodiscard]] std::string units_note(std::span<const batch::FrameRow> rows);

}  // namespace isoextract::cli

// The files of a batch besides its frames, and what is checked of all of them before the first frame.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "base/error.hpp"
#include "batch/frame_table.hpp"
#include "cli/batch_plan.hpp"
#include "files/read_files.hpp"

namespace isoextract::cli {

// Sees to the folders of all outputs of this run's frames. Fails with ErrorCode::output.
[[nodiscard]] Result<void> make_folders(const BatchPlan& plan);

// What all frames read, among it files that only the inputs name, where some file that would be written is there
// already, or names are known late (pieces): nothing else could be replaced. Fails with ErrorCode::usage where a file
// that would be written is read, and as convert::check_output_file() for those besides the frames.
[[nodiscard]] Result<std::optional<files::ReadFiles>> check_batch_files(const BatchPlan& plan);

// Whether lengths of the frames that have meshes are in more than one unit: a sentence with all of them, else empty.
[[nodiscard]] std::string note_of_units(std::span<const batch::FrameRow> rows);

}  // namespace isoextract::cli

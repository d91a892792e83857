// Plans the options of voxels and labels.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Turns --labels into iso choices, and makes surface nets their default method. Fails with ErrorCode::usage for
// --labels with other methods than voxels and surface nets, with iso values or a table of them, and for --labels all
// with {iso} in -o. Fails likewise for --label-names without --labels.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

// Sets the label table of `job`, whose resolution is already planned, and resampling to the nearest sample, because
// labels are never averaged. Fails with ErrorCode::usage for options without a meaning for labels, and as
// volume_io::LabelTable::read() does, which checks the table. Does nothing without --labels.
[[nodiscard]] Result<void> plan_labels(const ConvertFlags& flags, convert::ConversionJob& job);

// Returns whether --labels all is given.
[[nodiscard]] bool has_all_labels(const ConvertFlags& flags);

// Sets the options of voxel faces and surface nets of `surface`, whose method is already planned; --smooth turns off
// the merging of faces. Fails with ErrorCode::usage for options that the method lacks; adds notes about options without
// an effect.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, Notes& notes, convert::SurfaceOptions& surface);

}  // namespace isoextract::cli

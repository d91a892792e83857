// Plans the options of voxels and labels.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Turns --labels into iso choices, and makes surface nets the default method. Refuses --labels with methods without
// label support, with iso values, and with name patterns that need samples to be known. Refuses a label table without
// --labels.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

// Sets the labels of `job`, whose resolution is already planned; labels are never averaged. Refuses options without a
// meaning for labels. Reads the label table to check it.
[[nodiscard]] Result<void> plan_labels(const ConvertFlags& flags, convert::ConversionJob& job);

[[nodiscard]] bool has_all_labels(const ConvertFlags& flags);

// Sets the voxel options of `surface`, whose method is already planned. Refuses options that the method lacks; notes
// options without an effect.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, Notes& notes, convert::SurfaceOptions& surface);

}  // namespace isoextract::cli

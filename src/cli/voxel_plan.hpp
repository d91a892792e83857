// The options of voxels and of labels, as values of a job.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// --labels takes the place of --iso. Refused with another method than voxels, with iso values and with a pattern that
// cannot be filled in before the samples are read.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

[[nodiscard]] bool has_all_labels(const ConvertFlags& flags);

// Into `surface`, whose method is known. Refused where the method has none of it; what changes nothing is a note.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, std::vector<std::string>& notes,
                                       convert::SurfaceOptions& surface);

}  // namespace isoextract::cli

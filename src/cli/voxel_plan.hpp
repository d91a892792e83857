// The options of voxels and of labels, as values of a job.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// --labels takes the place of --iso, and surface nets that of the usual method. Refused with a method that has none,
// with iso values and with a pattern that cannot be filled in before the samples are read; and a table of their names
// without them.
[[nodiscard]] Result<void> take_labels(ConvertFlags& flags);

// Into `job`, whose resolution is planned: labels are never averaged. Refused with options that have no meaning for
// them. The table of their names is read to see that it is one.
[[nodiscard]] Result<void> plan_labels(const ConvertFlags& flags, convert::ConversionJob& job);

[[nodiscard]] bool has_all_labels(const ConvertFlags& flags);

// Into `surface`, whose method is known. Refused where the method has none of it; what changes nothing is a note.
[[nodiscard]] Result<void> plan_voxels(const ConvertFlags& flags, std::vector<std::string>& notes,
                                       convert::SurfaceOptions& surface);

}  // namespace isoextract::cli

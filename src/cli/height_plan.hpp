// --heightfield: the plan of terrain.
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Checks the options that do not work with --heightfield, and sets the iso value, which terrain does not use, to 0.
// Without --heightfield refuses the options that need it.
[[nodiscard]] Result<void> take_heights(ConvertFlags& flags);

// Sets the options of the terrain and how the input is read.
void plan_heights(const ConvertFlags& flags, convert::ConversionJob& job);

}  // namespace isoextract::cli

// Plans terrain (--heightfield).
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Chooses the surface of terrain (convert::SurfaceId::terrain()). Fails with ErrorCode::usage for options that do not
// work with
// --heightfield. Without --heightfield does nothing, but fails with ErrorCode::usage for --base.
[[nodiscard]] Result<void> take_heights(ConvertFlags& flags);

// Sets the terrain options, the NaN policy (by default NanPolicy::hole) and ReadOptions::flat of `job`. Does nothing
// without --heightfield.
void plan_heights(const ConvertFlags& flags, convert::ConversionJob& job);

}  // namespace isoextract::cli

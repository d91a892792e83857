// Plans the options for attributes, colors and opacity of vertices and surfaces.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "cli/options.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

// Sets attributes, colors and opacity of the job, whose format is already planned. `isos` is the number of iso values
// of the first input. Fails with ErrorCode::usage if the format cannot store attributes or materials, or if --opacity
// has neither one value nor `isos` values. Fails with the same code if --attribute repeats a name, or if --attribute
// and --color-by give one name different sources or settings.
[[nodiscard]] Result<void> plan_vertices(const ConvertFlags& flags, std::size_t isos, convert::ConversionJob& job);

// Inserts the frame number into the file names of attributes, such as heat=heat_{:04}.vdb[t]. Keeps names of existing
// files and demo fields. Fails as batch::FramePattern::parse() does.
[[nodiscard]] Result<void> number_attributes(std::vector<convert::AttributeChoice>& attributes, std::int64_t frame);

}  // namespace isoextract::cli

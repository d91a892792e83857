// The options of what vertices and surfaces look like: attributes, colours, opacity.
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

// What they say, into the job, whose format is known. Formats that have no place for it are refused. `isos` is how many
// iso values the first file has.
[[nodiscard]] Result<void> plan_vertices(const ConvertFlags& flags, std::size_t isos, convert::ConversionJob& job);

// For one frame: the number in place of a numbering in the names of other files, such as heat=heat_{:04}.vdb[t].
[[nodiscard]] Result<void> number_attributes(std::vector<convert::AttributeChoice>& attributes, std::int64_t frame);

// What is to be told of many frames: colours that are not those of one range; empty if there is nothing.
[[nodiscard]] std::string note_of_frames(const convert::ConversionJob& job);

}  // namespace isoextract::cli

// isoextract simulate: what is simulated, as files.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/simulate_plan.hpp"

namespace isoextract::cli {

// Before the work: sees to the folders of the frames' files, and that these can be written. Says which frames are left
// to be written, where files that are there are left alone; all of a frame's files, or none.
[[nodiscard]] Result<std::vector<SequenceFrame>> check_sequence(const SequencePlan& plan);

[[nodiscard]] Result<void> run_water(const WaterPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

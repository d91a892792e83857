// `isoextract simulate`: what the commands that simulate share.
#pragma once

#include <memory>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"
#include "cli/simulate_plan.hpp"

namespace isoextract::cli {

// Before the work: sees to the folders of the frames' files, and that these can be written. Says which frames are left
// to be written, where files that are there are left alone; all of a frame's files, or none.
[[nodiscard]] Result<std::vector<SequenceFrame>> check_sequence(const SequencePlan& plan);

[[nodiscard]] std::unique_ptr<Command> make_jet_command();

}  // namespace isoextract::cli

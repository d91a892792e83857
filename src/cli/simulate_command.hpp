// Functions that the commands of `isoextract simulate` share.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "cli/command.hpp"
#include "cli/simulate_plan.hpp"

namespace isoextract::cli {

// Checks before the simulation that the files of the frames are writable, and makes folders if the plan
// allows it. Returns the frames to write; with --no-clobber, leaves out each frame with at least one existing
// file. Fails with ErrorCode::output.
[[nodiscard]] Result<std::vector<SequenceFrame>> check_sequence(const SequencePlan& plan);

// Returns the seconds of a simulation and of the writing of its files, and the peak memory.
[[nodiscard]] std::string simulation_times_text(double simulating, double writing);

[[nodiscard]] std::unique_ptr<Command> make_jet_command();

}  // namespace isoextract::cli

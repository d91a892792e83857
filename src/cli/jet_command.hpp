// isoextract simulate jet: a particle jet, frame by frame, as files.
#pragma once

#include "base/error.hpp"
#include "cli/jet_plan.hpp"
#include "cli/messages.hpp"

namespace isoextract::cli {

[[nodiscard]] Result<void> run_jet(const JetPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

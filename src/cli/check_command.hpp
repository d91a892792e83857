// `isoextract check`: what is wrong with a mesh, as a table or JSON on stdout.
#pragma once

#include "base/error.hpp"
#include "cli/check_plan.hpp"
#include "cli/messages.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::verification, after the report, if the mesh is not what --require asks for.
[[nodiscard]] Result<void> run_check(const CheckPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

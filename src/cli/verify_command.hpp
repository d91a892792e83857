// `isoextract verify`: one backend against the other, or a written mesh against its volume, triangle by triangle.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::verification, after the report on stdout, if something differs.
[[nodiscard]] Result<void> run_verify(const VerifyPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

// `isoextract compare`: the facts of two meshes and the distances between them, as text or JSON on stdout.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::verification, after the report, if the meshes may be farther apart than --max-distance.
[[nodiscard]] Result<void> run_compare(const ComparePlan& plan, const Messages& messages);

}  // namespace isoextract::cli

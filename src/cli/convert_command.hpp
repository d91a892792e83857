// `isoextract convert`: a volume in, meshes out.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

[[nodiscard]] Result<void> run_convert(const ConvertPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

// `isoextract render`: volumes and meshes in, pictures out.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/render_plan.hpp"

namespace isoextract::cli {

// One picture after the other; it ends with the first that cannot be drawn or written.
[[nodiscard]] Result<void> run_render(const RenderPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

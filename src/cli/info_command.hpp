// `isoextract info`: what volumes hold, as text or JSON on stdout.
#pragma once

#include <optional>

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

// Reports on every input it can read. Errors are shown here; the first is also the answer, for the exit code.
[[nodiscard]] std::optional<Error> run_info(const InfoPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

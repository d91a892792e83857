// `isoextract bench`: error against run time, as a table on stdout, and as CSV, JSON and a picture.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/plan.hpp"

namespace isoextract::cli {

[[nodiscard]] Result<void> run_bench(const BenchPlan& plan, const Messages& messages);

}  // namespace isoextract::cli

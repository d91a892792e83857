// `isoextract stability`: extreme fields on every method and backend, checked vertex by vertex.
#pragma once

#include "base/error.hpp"
#include "cli/messages.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Prints the table, the JSON or the list of cases. Fails with ErrorCode::usage for a case that is not there, and with
// ErrorCode::verification, after the table, where a case does not pass.
[[nodiscard]] Result<void> run_stability(const StabilityFlags& flags, const Messages& messages);

}  // namespace isoextract::cli

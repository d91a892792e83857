// Limits the threads of the program.
#pragma once

#include <optional>

#include "base/error.hpp"

namespace isoextract::cli {

// Limits oneTBB to `threads` threads until the program ends; by default to all that this process may use. Call once,
// before any work. Fails with ErrorCode::unavailable if the system cannot start them all, because oneTBB is unreliable
// without its threads. Starts none for a limit of 1.
[[nodiscard]] Result<void> limit_threads(const std::optional<int>& threads);

}  // namespace isoextract::cli

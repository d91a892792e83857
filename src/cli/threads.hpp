// The threads that the program works on.
#pragma once

#include <optional>

#include "base/error.hpp"

namespace isoextract::cli {

// Keeps oneTBB to so many threads, or to all of the machine, from now on until the program ends, and sees that they can
// be had: where the system refuses oneTBB one, nothing of the work can be counted on. One thread needs no other. Called
// once, before any work. Fails with ErrorCode::unavailable.
[[nodiscard]] Result<void> limit_threads(const std::optional<int>& threads);

}  // namespace isoextract::cli

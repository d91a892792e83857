// `isoextract merge`: the shards of a batch joined.
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// ErrorCode::frames where all shards are done, but frames that were asked for have no input.
[[nodiscard]] Result<void> run_merge(const MergeFlags& flags);

}  // namespace isoextract::cli

// `isoextract devices`: what the GPU backend can draw on.
#pragma once

#include "base/error.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::unavailable where there is no device at all. Devices that cannot be used are listed with why.
[[nodiscard]] Result<void> run_devices(const DevicesFlags& flags);

}  // namespace isoextract::cli

// How a comparison of backends is told.
#pragma once

#include <string>

#include "convert/verification.hpp"

namespace isoextract::cli {

// "verified at iso 0.5: gpu gives the same 12 triangles and 8 vertices as cpu, at most 0.5 ulps apart; 0.01 s"
[[nodiscard]] std::string verification_summary(const convert::VerificationRecord& record);

// The table that `verify` prints.
[[nodiscard]] std::string verification_table(const std::string& label, const convert::VerificationRecord& record);

}  // namespace isoextract::cli

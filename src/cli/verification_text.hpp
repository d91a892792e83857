// How a comparison of backends is told.
#pragma once

#include <string>

#include "convert/verification.hpp"

namespace isoextract::cli {

// The table that `verify` prints.
[[nodiscard]] std::string verification_table(const std::string& label, const convert::VerificationRecord& record);

}  // namespace isoextract::cli

// Formats a comparison of backends.
#pragma once

#include <string>

#include "convert/verification.hpp"

namespace isoextract::cli {

// Returns the table that `verify` prints.
[[nodiscard]] std::string verification_table(const std::string& label, const convert::VerificationRecord& record);

}  // namespace isoextract::cli

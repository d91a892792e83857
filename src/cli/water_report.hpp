// Formats the results of `stability` for the two water rules, as a table and as JSON.
#pragma once

#include <string>
#include <vector>

#include "convert/json_type.hpp"
#include "simulate/water_stability.hpp"

namespace isoextract::cli {

// The conservative rule decides whether a case passes. The rule as printed in the paper may fail; the table shows its
// failures.
[[nodiscard]] std::string water_table(const std::vector<simulate::WaterStabilityRow>& rows);
[[nodiscard]] convert::Json water_json(const std::vector<simulate::WaterStabilityRow>& rows);
[[nodiscard]] std::size_t count_failed(const std::vector<simulate::WaterStabilityRow>& rows);

}  // namespace isoextract::cli

// Formats the results of `stability` for both rules of the water automaton (simulate::WaterRule), as a table and JSON.
#pragma once

#include <string>
#include <vector>

#include "convert/json_type.hpp"
#include "simulate/water_stability.hpp"

namespace isoextract::cli {

// Returns the table of all cases. The conservative rule alone decides whether a case passes; the table also shows the
// failures of the rule as printed in Kostritskii's report (docs/papers.md).
[[nodiscard]] std::string water_table(const std::vector<simulate::WaterStabilityRow>& rows);
[[nodiscard]] convert::Json water_json(const std::vector<simulate::WaterStabilityRow>& rows);
// Returns the number of cases that fail with the conservative rule.
[[nodiscard]] std::size_t count_failed(const std::vector<simulate::WaterStabilityRow>& rows);

}  // namespace isoextract::cli

// What `stability` found about the two rules of water, as a table and as JSON.
#pragma once

#include <string>
#include <vector>

#include "convert/json_type.hpp"
#include "simulate/water_stability.hpp"

namespace isoextract::cli {

// The conservative rule decides what passes. The printed one is expected to fail: how is told beside.
[[nodiscard]] std::string water_table(const std::vector<simulate::WaterStabilityRow>& rows);
[[nodiscard]] convert::Json water_json(const std::vector<simulate::WaterStabilityRow>& rows);
[[nodiscard]] std::size_t count_failed(const std::vector<simulate::WaterStabilityRow>& rows);

}  // namespace isoextract::cli

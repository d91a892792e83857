#include "cli/water_report.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "convert/json_values.hpp"

namespace isoextract::cli {
namespace {

std::string water_columns(const simulate::WaterFindings& found) {
  return fmt::format("{:>9.2g} {:>8.1e} {:>8.1e}", found.least_depth, found.drift, found.most_energy);
}

convert::Json findings_json(const simulate::WaterFindings& found, const std::vector<std::string>& failures) {
  // Infinite numbers become null, since JSON cannot represent them.
  return {{"passed", failures.empty()},
          {"failures", failures},
          {"least_depth", found.least_depth},
          {"drift", found.drift},
          {"most_energy", found.most_energy},
          {"steps", found.steps},
          {"finite", found.finite}};
}

}  // namespace

std::size_t count_failed(const std::vector<simulate::WaterStabilityRow>& rows) {
  return static_cast<std::size_t>(std::ranges::count_if(rows, [](const simulate::WaterStabilityRow& row) {
    return !row.conservative.failures(row.energy_allowed).empty();
  }));
}

std::string water_table(const std::vector<simulate::WaterStabilityRow>& rows) {
  std::string text = fmt::format("{:<30}{:<28} {}\n", "water", "conservative rule", "printed rule");
  text += fmt::format("{:<10} {:>8} {:>9} {:>9} {:>8} {:>8} {:>9} {:>8} {:>8}  {}\n", "case", "friction", "flow-div",
                      "min depth", "drift", "energy", "min depth", "drift", "energy", "verdict");
  std::size_t printed_failures = 0;
  for (const simulate::WaterStabilityRow& row : rows) {
    const auto wrong = row.conservative.failures(row.energy_allowed);
    const auto wrong_as_printed = row.printed.failures(row.energy_allowed);
    printed_failures += wrong_as_printed.empty() ? 0 : 1;
    text += fmt::format(
        "{:<10} {:>8} {:>9} {} {}  {}{}\n", row.name, row.friction, row.flow_div, water_columns(row.conservative),
        water_columns(row.printed), wrong.empty() ? "pass" : fmt::format("FAIL: {}", fmt::join(wrong, "; ")),
        wrong_as_printed.empty() ? "" : fmt::format(" (printed, as expected: {})", fmt::join(wrong_as_printed, "; ")));
  }
  return text + fmt::format("water: {} of {} cases pass with the conservative rule, {} with the printed rule\n",
                            rows.size() - count_failed(rows), rows.size(), rows.size() - printed_failures);
}

convert::Json water_json(const std::vector<simulate::WaterStabilityRow>& rows) {
  convert::Json json = convert::Json::array();
  for (const simulate::WaterStabilityRow& row : rows) {
    json.push_back({{"case", row.name},
                    {"friction", row.friction},
                    {"flow_div", row.flow_div},
                    {"drift_allowed", simulate::kDriftAllowed},
                    {"energy_allowed", row.energy_allowed},
                    {"conservative", findings_json(row.conservative, row.conservative.failures(row.energy_allowed))},
                    {"printed", findings_json(row.printed, row.printed.failures(row.energy_allowed))}});
  }
  return json;
}

}  // namespace isoextract::cli

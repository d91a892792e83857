// The report of a conversion: what the plan says of it, and its file.
#pragma once

#include <string>

#include "base/error.hpp"
#include "batch/conversion_report.hpp"
#include "cli/plan.hpp"

namespace isoextract {

// A report of what is known before the work: arguments, options, device.
[[nodiscard]] ConversionReport begin_report(const ConvertPlan& plan);

// Whole or not there, as all output.
[[nodiscard]] Result<void> write_report(const std::string& path, const ConversionReport& report);

}  // namespace isoextract

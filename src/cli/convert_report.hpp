// The report of a conversion: what the plan says of it, and its file.
#pragma once

#include <string>

#include "base/error.hpp"
#include "cli/plan.hpp"
#include "convert/conversion_report.hpp"

namespace isoextract::cli {

// A report of what is known before the work: arguments, options, device.
[[nodiscard]] convert::ConversionReport begin_report(const ConvertPlan& plan);

// Whole or not there, as all output.
[[nodiscard]] Result<void> write_report(const std::string& path, const convert::ConversionReport& report);

}  // namespace isoextract::cli

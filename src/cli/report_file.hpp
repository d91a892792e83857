// The report of a conversion as a file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "convert/outcome.hpp"

namespace isoextract::cli {

// Whether `path` is none of the job's inputs and outputs; the hint names the option.
[[nodiscard]] Result<void> check_report_file(const std::string& path, const convert::ConversionJob& job,
                                             const Context& context);

// `job` as convert::report_of() has it. `notes` come before those of the outcome.
[[nodiscard]] Result<void> write_report(const std::string& path, const convert::ConversionJob* job,
                                        const convert::Outcome& outcome, const std::vector<std::string>& notes,
                                        const std::vector<std::string>& arguments, std::uint64_t memory_limit);

}  // namespace isoextract::cli

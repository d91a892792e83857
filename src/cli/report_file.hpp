// Writes the report of a conversion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/outcome.hpp"

namespace isoextract::cli {

// Fails if `path` is one of the job's inputs or outputs; the hint names the option.
[[nodiscard]] Result<void> check_report_file(const std::string& path, const convert::ConversionJob& job,
                                             const Context& context);

// `job` is passed to convert::report_of(). `notes` precede those of the outcome.
[[nodiscard]] Result<void> write_report(const std::string& path, const convert::ConversionJob* job,
                                        const convert::Outcome& outcome, const Notes& notes,
                                        const std::vector<std::string>& arguments, std::uint64_t memory_limit);

}  // namespace isoextract::cli

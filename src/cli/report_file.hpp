// Writes the report of a conversion.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/outcome.hpp"

namespace isoextract::cli {

// Fails with ErrorCode::usage if `path` is, or may become, one of the job's inputs or outputs; the hint names --report.
// Fails with ErrorCode::output if it is not writable.
[[nodiscard]] Result<void> check_report_file(const std::string& path, const convert::ConversionJob& job,
                                             const Context& context);

// Writes the report that convert::report_of() makes from `job` (may be null) and `outcome`. In the report, `notes` come
// before the notes of the outcome. `memory_limit` is in bytes. Fails with ErrorCode::output.
[[nodiscard]] Result<void> write_report(const std::string& path, const convert::ConversionJob* job,
                                        const convert::Outcome& outcome, const Notes& notes,
                                        const std::vector<std::string>& arguments, std::uint64_t memory_limit);

}  // namespace isoextract::cli

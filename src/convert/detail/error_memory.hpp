// Memory needed to measure the error of meshes, checked before the work.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Checks, if the job measures errors, that the memory limit leaves room for a lower bound of the memory that extracting
// and measuring each iso value takes beside the reservations of this conversion. Call before extracting. Fails with
// ErrorCode::out_of_memory and the hint to raise the limit.
[[nodiscard]] Result<void> check_error_memory(const ConversionJob& job, const Source& source, const Context& context);

// Returns the estimated memory for measuring besides the mesh, at an iso value.
[[nodiscard]] std::uint64_t estimated_error_bytes(const Source& source, double iso);

}  // namespace isoextract::convert

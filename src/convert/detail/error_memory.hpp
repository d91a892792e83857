// Memory needed to measure the error of meshes, checked before the work.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Checks that the memory limit leaves room to extract and measure the surface at each iso value, for jobs that measure
// errors. Compares a lower bound of the memory needed with the limit minus the reservations of this conversion. Call
// before extracting. Fails with ErrorCode::out_of_memory and the hint to raise the limit.
[[nodiscard]] Result<void> check_error_memory(const ConversionJob& job, const Source& source, const Context& context);

// Returns the estimated memory that measuring the surface at `iso` takes, without the mesh itself.
[[nodiscard]] std::uint64_t estimated_error_bytes(const Source& source, double iso);

}  // namespace isoextract::convert

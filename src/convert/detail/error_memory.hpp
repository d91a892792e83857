// The memory that measuring the error of meshes takes, before the work.
#pragma once

#include <cstdint>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Before any surface is extracted: whether the memory is left that extracting and measuring the surfaces of `source`
// needs at least. Fails with ErrorCode::out_of_memory and Remedy::raise_memory_limit.
[[nodiscard]] Result<void> check_error_memory(const ConversionJob& job, const Source& source, const Context& context);

// About what measuring takes beside the mesh, at an iso value.
[[nodiscard]] std::uint64_t estimated_error_bytes(const Source& source, double iso);

}  // namespace isoextract::convert

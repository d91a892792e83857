// The stage that writes the field as an OpenVDB file instead of surfaces.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Writes `source.field` to one output of `job`, completely or not at all, and reports it. Stores 32-bit floats, or
// 16-bit floats with FieldFileOptions::as_half; the report says if values were rounded. Fails with ErrorCode::output if
// values exceed the stored type's range, and as volume_io::write_vdb() does.
[[nodiscard]] Result<mesh_io::WrittenFile> write_field(const Source& source, const ConversionJob& job,
                                                       const OutputFileJob& output, const Context& context,
                                                       Events& events);

}  // namespace isoextract::convert

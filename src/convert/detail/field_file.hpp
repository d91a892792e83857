// The stage that writes the field as a file instead of surfaces.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Fails if the job writes VDB files and the plug-in for them is missing; `work` starts the message.
[[nodiscard]] Result<void> check_field_tools(const ConversionJob& job, const std::string& work);

// Writes `source.field` to one output of `job`, completely or not at all, and reports it. A VDB file stores 32-bit
// floats, or 16-bit floats with FieldFileOptions::as_half. Other files hold dense samples (field/dense_field.hpp) of
// the field's type; 16-bit floats become 32-bit ones in formats without them, and scaled values become 32-bit or 64-bit
// floats. The report says if values were rounded; notes tell which facts the file lacks. Fails with ErrorCode::output
// if values exceed the stored type's range, and as write_vdb() or field::as_dense() and volume_io::write_volume() do.
[[nodiscard]] Result<mesh_io::WrittenFile> write_field(const Source& source, const ConversionJob& job,
                                                       const OutputFileJob& output, const Context& context,
                                                       Events& events);

}  // namespace isoextract::convert

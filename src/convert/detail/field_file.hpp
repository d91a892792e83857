// The stage that writes the field itself, as an OpenVDB file, in place of surfaces.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"

namespace isoextract::convert {

// Writes `source.field` to one output of `job`, whole or not at all, and tells of it. Values are 32-bit floats, or
// 16-bit ones; a note says by how much that rounds them. Fails with ErrorCode::output where values leave the range of
// their numbers, and as volume_io::write_vdb() does.
[[nodiscard]] Result<mesh_io::WrittenFile> write_field(const Source& source, const ConversionJob& job,
                                                       const OutputFileJob& output, const Context& context,
                                                       Events& events);

}  // namespace isoextract::convert

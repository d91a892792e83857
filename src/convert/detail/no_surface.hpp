// Errors of conversions that have no surface: why, and what helps.
#pragma once

#include <optional>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/iso_values.hpp"
#include "convert/source.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {

// Of a source that is empty.
[[nodiscard]] Error empty_source(const Source& source);

// Of a surface without triangles. Looks at all samples, unless the source is empty, `asked` is one of `are_labels`, or
// the surface was in `cut_away`, in output coordinates, and planes or a region left nothing of it.
[[nodiscard]] Error no_surface(const ConversionJob& job, const Source& source, const ResolvedIso& asked,
                               bool are_labels, const std::optional<mesh::Bounds>& cut_away);

}  // namespace isoextract::convert

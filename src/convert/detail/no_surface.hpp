// Errors of conversions without a surface: the reason, and a hint.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "convert/conversion_job.hpp"
#include "convert/detail/label_choice.hpp"
#include "convert/events.hpp"
#include "convert/iso_values.hpp"
#include "convert/source.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::convert {

// Returns the error for an empty source.
[[nodiscard]] Error empty_source(const Source& source);

// Removes the old file of an output without samples or particles, and notes that the output was not written. Fails with
// empty_source() for EmptyPolicy::error.
[[nodiscard]] Result<void> leave_out_empty(const Source& source, const ConversionJob& job, const OutputFileJob& output,
                                           const Context& context, Events& events);

// Returns the error for a label map without a label to extract. The source is empty, the map has only the background,
// the choice includes none of its labels, or those that it includes are all too small.
[[nodiscard]] Error no_label(const Source& source, std::int64_t background, const LabelCounts& labels);

// Returns the note that an output was not written because of no_label(); `besides` says what else happened to it.
[[nodiscard]] Note note_of_no_label(const Error& none, const OutputFileJob& output, const std::string& besides);

// Returns the error for a surface without triangles. If clipping left nothing of the surface, `cut_away` has its bounds
// before clipping, in output coordinates. Examines all samples, except for an empty source, for a label (`are_labels`),
// or with `cut_away`.
[[nodiscard]] Error no_surface(const ConversionJob& job, const Source& source, const ResolvedIso& asked,
                               bool are_labels, const std::optional<mesh::Bounds>& cut_away);

}  // namespace isoextract::convert

// Makes a note if an iso value is asked of a label map or a mask.
#pragma once

#include <optional>

#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

// Returns a note that names a better way if the samples of `field` look like labels (field::guess_label_map()), and
// `job` extracts an iso value from them by a method that interpolates. Otherwise returns nullopt. Cheap for large
// fields.
[[nodiscard]] std::optional<Note> iso_of_labels_note(const field::ScalarField& field,
                                                     const convert::ConversionJob& job);

// Returns a note that names --labels if the samples of `field`, which is drawn as a volume, look like a label map.
// Otherwise returns nullopt.
[[nodiscard]] std::optional<Note> volume_of_labels_note(const field::ScalarField& field);

}  // namespace isoextract::cli

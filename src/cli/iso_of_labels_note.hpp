// Makes notes about label maps and masks that are extracted at an iso value or drawn as a volume.
#pragma once

#include <optional>

#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

// Returns a note that names a better option if the samples of `field` look like labels (field::guess_label_map()), and
// `job` extracts a surface at an iso value by a method that interpolates. Otherwise returns nullopt. Fast for large
// fields.
[[nodiscard]] std::optional<Note> iso_of_labels_note(const field::ScalarField& field,
                                                     const convert::ConversionJob& job);

// Returns a note that names --labels if the samples of `field`, which is drawn as a volume, look like a label map (not
// a mask). Otherwise returns nullopt.
[[nodiscard]] std::optional<Note> volume_of_labels_note(const field::ScalarField& field);

}  // namespace isoextract::cli

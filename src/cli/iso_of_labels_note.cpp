#include "cli/iso_of_labels_note.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "convert/field_label.hpp"
#include "extract/method.hpp"
#include "field/label_map.hpp"

namespace isoextract::cli {

std::optional<Note> iso_of_labels_note(const field::ScalarField& field, const convert::ConversionJob& job) {
  if (!extract::method_info(job.surface.method).traits.follows_interpolant) return std::nullopt;
  const std::vector<convert::IsoChoice> isos = job.isos();
  if (std::ranges::all_of(isos, &convert::IsoChoice::is_label)) return std::nullopt;
  const auto kind = field::guess_label_map(field);
  if (!kind) return std::nullopt;
  const std::string label = convert::field_label(field);
  if (*kind == field::LabelMapKind::binary_mask) {
    return Note{NoteId::iso_of_labels,
                fmt::format("{}: the samples look like a binary mask: a surface at an iso value keeps the steps of the "
                            "voxels; --method surface-nets makes a smooth one",
                            label)};
  }
  return Note{NoteId::iso_of_labels,
              fmt::format("{}: the samples look like a label map: a surface at an iso value joins all labels above it; "
                          "--labels all makes a mesh of each label",
                          label)};
}

std::optional<Note> volume_of_labels_note(const field::ScalarField& field) {
  if (field::guess_label_map(field) != field::LabelMapKind::label_map) return std::nullopt;
  return Note{
      NoteId::iso_of_labels,
      fmt::format("{}: the samples look like a label map: the volume takes the numbers of labels for densities; "
                  "--labels all draws the surface of each label",
                  convert::field_label(field))};
}

}  // namespace isoextract::cli

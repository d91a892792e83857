// The labels that `info` lists for a label map or mask: their figures, names and colors.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "cli/layout.hpp"
#include "convert/json_type.hpp"
#include "convert/mask_layers.hpp"
#include "field/label_map.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::cli {

struct LabelReport {
  field::LabelMap map;
  std::vector<field::LabelName> names;  // of the described volume, in ascending order of label
  std::size_t layers = 0;               // number of label maps that hold the masks of --masks; 0 without --masks
  std::string table;                    // path of the table beside the input, if the names come from it; else empty

  // Returns the entry with the name and color of a label, or null.
  [[nodiscard]] const field::LabelName* find(std::int64_t label) const;
};

// Returns the labels of `field`, which was read from `input`, or nothing if it is neither label map nor mask. Takes the
// names for `volume` from the field, or from a table beside the input if the field has no names. Adds a note to the
// field if the table is unusable.
[[nodiscard]] std::optional<LabelReport> report_labels(const std::string& input, std::optional<std::int64_t> volume,
                                                       const Context& context, field::ScalarField& field);

// Returns the labels of masks; nothing if no mask has a voxel.
[[nodiscard]] std::optional<LabelReport> report_masks(const convert::MaskLayers& masks);

// Adds the kind of the field, and for each of the first 20 labels the number of voxels, volume, bounds and name. Lists
// named labels without voxels, unless the names come from a table.
void add_label_map(NamedLines& lines, const LabelReport& report, const field::ScalarField& field);

// Describes the meshes that --labels all makes of the labels.
[[nodiscard]] std::string surfaces_text(const LabelReport& report);

// Returns the kind, the background and all labels as JSON.
[[nodiscard]] convert::Json json_of(const LabelReport& report, const field::ScalarField& field);

}  // namespace isoextract::cli

// Placement of a volume in the world, from its file and the options.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Placement as stated in a file. An invalid placement is only an error if the options do not replace it.
struct Frame {
  field::Affine index_to_world;
  std::string problem;  // "axis 2 has no direction"; empty if valid
  bool stated = true;   // false: the file has no spacing and origin, and this is the format's default
  // Notes about assumed axes and an assumed origin; reported unless the options replace these.
  Notes assumed_axes = {};
  Notes assumed_origin = {};
};

// Sets the field's index_to_world from its file and the options' spacing, origin and beside; requires the field's
// samples. Messages name field.source. Fails with ErrorCode::input if there is no valid placement.
[[nodiscard]] Result<void> set_placement(field::ScalarField& field, const Frame& frame, const ReadOptions& options);

}  // namespace isoextract::volume_io

// Where a volume is in the world: what its file says, and what the options say instead.
#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "field/scalar_field.hpp"
#include "volume_io/volume_format.hpp"

namespace isoextract::volume_io {

// Where a file says its samples are. A frame that cannot be used is only an error if the options do not replace it.
struct Frame {
  field::Affine index_to_world;
  std::string problem;  // "axis 2 has no direction"; empty if all is well
  bool stated = true;   // false: the file states no spacing and no origin, and this is the format's default
  std::vector<std::string> assumed = {};  // what of it the file does not state; told where it counts
};

// Sets the field's index_to_world from its file and the options' spacing, origin and beside; its samples are there.
// Messages name field.source. Fails with ErrorCode::input where nothing states a placement that can be used.
[[nodiscard]] Result<void> set_frame(field::ScalarField& field, const Frame& frame, const ReadOptions& options);

}  // namespace isoextract::volume_io

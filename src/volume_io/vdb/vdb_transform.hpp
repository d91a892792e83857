// Reads the transform of a grid in a VDB file.
#pragma once

#include "volume_io/detail/placement.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"

namespace isoextract::volume_io {

struct VdbPlacement : Frame {
  bool is_frustum = false;  // a camera's frustum, which no linear map describes; also sets `problem`
};

// Reads the transform and leaves the cursor at the grid's tree. Frustums and singular matrices set the frame's
// `problem`. Throws InvalidVdb, and UnsupportedVdb for unknown transforms, whose end cannot be found.
[[nodiscard]] VdbPlacement read_vdb_transform(VdbCursor& cursor);

}  // namespace isoextract::volume_io

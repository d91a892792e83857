// The transform of a grid in a VDB file.
#pragma once

#include "volume_io/detail/placing.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"

namespace isoextract::volume_io {

struct VdbFrame : Frame {
  bool is_frustum = false;  // a camera's view, which no linear map describes: one kind of `problem`
};

// Leaves the cursor behind the transform, where the grid's tree begins. Frustums and matrices without an inverse are
// the frame's `problem`. Throws VdbDamaged, and VdbUnsupported for transforms of an unknown name: nobody knows where
// those end.
[[nodiscard]] VdbFrame read_vdb_transform(VdbCursor& cursor);

}  // namespace isoextract::volume_io

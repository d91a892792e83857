// Passing over a grid's tree without unpacking it, in files that do not say where it ends.
#pragma once

#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_header.hpp"

namespace isoextract::volume_io {

// The cursor is at the tree, and then behind it. Throws VdbDamaged, and VdbUnsupported for trees of a shape or of
// values whose sizes are not known.
void skip_vdb_tree(VdbCursor& cursor, const VdbGridRecord& grid);

}  // namespace isoextract::volume_io

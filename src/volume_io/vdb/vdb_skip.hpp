// Skips a grid's tree without decompressing it, in files that do not store its end.
#pragma once

#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_header.hpp"

namespace isoextract::volume_io {

// Moves the cursor from the start of the tree to its end. Throws InvalidVdb, and UnsupportedVdb for trees whose
// configuration or value size is unknown.
void skip_vdb_tree(VdbCursor& cursor, const VdbGridRecord& grid);

}  // namespace isoextract::volume_io

// Reads the tree of a scalar grid in a VDB file: a root, upper nodes of 32^3 entries, lower nodes of 16^3 entries,
// leaves of 8^3 values. The file stores first the topology (masks and tiles), then the values of the leaves.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "field/samples.hpp"
#include "volume_io/vdb/vdb_cursor.hpp"
#include "volume_io/vdb/vdb_values.hpp"

namespace isoextract::volume_io {

struct VdbTopology {
  field::SparseSamples samples;                     // blocks in file order, without values; tiles
  std::vector<std::array<std::uint64_t, 8>> masks;  // active masks of the blocks
  Reservation blocks_memory;                        // for samples.blocks
  Reservation tiles_memory;                         // for samples.tiles
  Reservation masks_memory;
};

// Context for memory reservations, and names for messages.
struct VdbTreeLimits {
  const Context& context;
  std::string file;
  std::string grid;
};

// Reads the topology; moves the cursor from the tree to the leaves' values. Throws InvalidVdb, UnsupportedVdb for voxel
// indices out of range, and VdbReadError if memory for tiles and blocks is refused. For float, double and int32_t.
template <class Value>
[[nodiscard]] VdbTopology read_vdb_topology(VdbCursor& cursor, const VdbValueLayout& layout,
                                            const VdbTreeLimits& limits);

// Reads the values of the blocks in parallel. The result is sorted and owns its values and reservations. Throws as
// read_vdb_topology() does.
template <class Value>
[[nodiscard]] field::SparseSamples read_vdb_leaves(VdbCursor& cursor, const VdbValueLayout& layout,
                                                   const VdbTreeLimits& limits, VdbTopology topology);

}  // namespace isoextract::volume_io

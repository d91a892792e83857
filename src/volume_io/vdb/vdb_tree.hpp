// The tree of a scalar grid in a VDB file: a root with nodes of 32^3 nodes of 16^3 leaves of 8^3 values. First its
// topology, masks and tiles, then the values of its leaves.
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
  field::SparseSamples samples;                     // blocks in the order of the file, without values; tiles
  std::vector<std::array<std::uint64_t, 8>> masks;  // of the blocks: the active values
  Reservation blocks_memory;                        // of samples.blocks
  Reservation tiles_memory;                         // of samples.tiles
  Reservation masks_memory;
};

// Where memory is reserved, and what messages call it.
struct VdbTreeLimits {
  const Context& context;
  std::string file;
  std::string grid;
};

// The cursor is at the tree, and then where the leaves' values begin. Throws VdbDamaged, and VdbRefused before tiles
// and blocks need more memory than there is. For float, double and int32_t.
template <class Value>
[[nodiscard]] VdbTopology read_vdb_topology(VdbCursor& cursor, const VdbValueLayout& layout,
                                            const VdbTreeLimits& limits);

// Fills the blocks, many at a time; after that they are sorted, and own their values and all that is reserved for them.
// Throws as the topology does.
template <class Value>
[[nodiscard]] field::SparseSamples read_vdb_leaves(VdbCursor& cursor, const VdbValueLayout& layout,
                                                   const VdbTreeLimits& limits, VdbTopology topology);

}  // namespace isoextract::volume_io

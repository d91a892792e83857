// Finds the blocks that a blurred sparse grid needs.
#pragma once

#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/samples.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

struct BlurredBlocks {
  std::vector<glm::ivec3> origins;  // sorted like SparseSamples::blocks
  std::vector<SparseTile> tiles;    // the parts of the tiles that stay constant
  Reservation memory;               // of these lists
};

// Returns the blocks and tiles of a grid blurred by a filter that reaches `reach` voxels. A place becomes a block if a
// stored block or a different value is at most ceil(reach / 8) places away; all others stay constant. `what` starts the
// message if memory runs out.
[[nodiscard]] Result<BlurredBlocks> find_blurred_blocks(const SparseSamples& samples, const SparseLookup& lookup,
                                                        int reach, const std::string& what, const Context& context);

}  // namespace isoextract::field

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

// The filter reaches `reach` voxels. A block-sized place stays as it is if all samples within reach have one value;
// every other place becomes a block. `what` starts the message if memory runs out.
[[nodiscard]] Result<BlurredBlocks> find_blurred_blocks(const SparseSamples& samples, const SparseLookup& lookup,
                                                        int reach, const std::string& what, const Context& context);

}  // namespace isoextract::field

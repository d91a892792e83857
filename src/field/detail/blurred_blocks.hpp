// Which blocks a sparse grid has when each sample is made of those around it.
#pragma once

#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/samples.hpp"
#include "field/sparse_lookup.hpp"

namespace isoextract::field {

struct BlurredBlocks {
  std::vector<glm::ivec3> origins;  // sorted as blocks are
  std::vector<SparseTile> tiles;    // what is left of the tiles
  Reservation memory;               // for these lists
};

// Samples are made of those up to `reach` voxels away. Places whose surroundings have one value stay as they are; all
// others are blocks. `what` starts the message where the memory is not there.
[[nodiscard]] Result<BlurredBlocks> find_blurred_blocks(const SparseSamples& samples, const SparseLookup& lookup,
                                                        int reach, const std::string& what, const Context& context);

}  // namespace isoextract::field

#pragma once

#include "extract/extractor.hpp"

namespace isoextract::extract {

// Extracts the surface of a sparse field without making it dense; `samples` are the samples of `field`. Visits only
// bricks of 8x8x8 samples whose cells may have corners on both sides of the iso value. These are the stored blocks, and
// the bricks without a block that are next to a block or at the skin of a tile. A brick without a block has one value,
// that of the tile or the background. The passes are those of dense_extractor.hpp, but with 512 bits a brick.
[[nodiscard]] Result<Extraction> extract_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                                                const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

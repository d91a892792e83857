// Extraction from sparse blocks, tiles and a background, without making them dense.
#pragma once

#include "extract/extractor.hpp"

namespace isoextract::extract {

// `samples` are those of `field`. Only blocks of 8 x 8 x 8 samples around which both sides occur are visited: stored
// blocks, and places next to a stored block or at the skin of a tile, whose samples all have the tile's or the
// background's value. The passes are those of dense_extractor.hpp, with 512 bits a block in place of rows.
[[nodiscard]] Result<Extraction> extract_sparse(const field::ScalarField& field, const field::SparseSamples& samples,
                                                const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

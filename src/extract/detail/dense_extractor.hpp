#pragma once

#include "extract/extractor.hpp"

namespace isoextract::extract {

// Extracts the surface of a dense field; `samples` are the samples of `field`. The passes:
//   1. classify: one bit a sample, every sample read once (dense_masks.hpp). If the bits need more than half of the
//     memory left, or ranks share the volume, the count and emit passes classify slab by slab instead;
//   2. count: for each row of cells, the crossed edges of each direction and the triangles; skips bricks whose
//     samples are all on one side;
//   3. prefix sums over the rows: exact sizes, and the first vertex and triangle of each row, whatever its thread;
//   4. emit: vertices and triangles, written once, in place;
//   5. cap, if requested (boundary_cap.hpp).
[[nodiscard]] Result<Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                               const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

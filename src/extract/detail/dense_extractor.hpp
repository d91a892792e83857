#pragma once

#include "extract/extractor.hpp"

namespace isoextract::extract {

// Extracts the surface of a dense field; `samples` are the samples of `field`. The passes:
//   1. classify: one bit a sample, every sample read once (dense_masks.hpp);
//   2. count: for each row of cells, the crossed edges of each direction and the triangles; skips bricks whose
//     samples are all on one side;
//   3. prefix sums over the rows: exact sizes, and the place where every row writes, independent of its thread;
//   4. emit: vertices and triangles, written once, in place;
//   5. cap, if requested (boundary_cap.hpp).
[[nodiscard]] Result<Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                               const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

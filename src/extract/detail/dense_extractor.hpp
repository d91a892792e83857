// Extraction from a dense array of samples.
#pragma once

#include "extract/extractor.hpp"

namespace isoextract::extract {

// `samples` are those of `field`. The passes:
//   1. classify: one bit a sample, every sample read once (dense_masks.hpp);
//   2. count: per row of cells, the crossed edges of each direction and the triangles; rows in bricks of which all
//      samples are on one side are not visited;
//   3. prefix sums over the rows: exact sizes, and where every row writes, whatever thread it runs on;
//   4. emit: vertices and triangles, written once, in place;
//   5. cap, if asked for (border_cap.hpp).
[[nodiscard]] Result<Extraction> extract_dense(const field::ScalarField& field, const field::DenseSamples& samples,
                                               const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

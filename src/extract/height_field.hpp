// Terrain: a dense field with one sample along z is a field of heights, and its surface is made directly, without an
// iso value. The vertex of sample (i, j) is the index position (i, j, value); the transform turns it into a world
// position, so that the spacing along z is the scale of the heights. Each square of four samples has two triangles, cut
// from (i, j) to (i + 1, j + 1); squares with a NaN corner (NanPolicy::hole) have none.
//
// The surface is open, or closed by walls and a flat floor below the lowest height. The closed mesh is an oriented
// 2-manifold: where squares touch at a corner only, each has a vertex of its own. Without holes the floor is a fan
// around its middle; with holes it repeats the squares. The volume is that of the samples by the trapezoid rule,
// plus (h00 - h10 - h01 + h11) / 12 times the area of a square, with the samples at the four corners of the data.
#pragma once

#include <array>
#include <optional>

#include "extract/extractor.hpp"

namespace isoextract::extract {

struct HeightOptions {
  static constexpr std::array kMembers{"solid", "base"};

  bool solid = true;           // closed by walls and a floor
  std::optional<double> base;  // value of the floor; default: below the lowest height by a tenth of their range, at
                               // least by 1 if all are equal

  friend bool operator==(const HeightOptions&, const HeightOptions&) = default;
};

// Returns the surface. Of `options`, only `nan` and `output_from_index` have an effect; NanPolicy::outside is as hole.
//
// Fails with ErrorCode::input for sparse fields, more than one sample along z, and fewer than two along x or y. Fails
// so for NaN samples with NanPolicy::error, infinite ones, and a base that is not below all heights. Fails so for a
// singular transform and for coordinates that float32 cannot hold. Fails with ErrorCode::out_of_memory or cancelled.
// The mesh has no normals.
[[nodiscard]] Result<Extraction> extract_heights(const field::ScalarField& field, const HeightOptions& heights,
                                                 const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

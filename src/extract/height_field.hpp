// Terrain: a dense field with one sample along z is a field of heights, and its surface is made directly, without an
// iso value. The vertex of sample (i, j) is the index position (i, j, value); the transform turns it into a world
// position, so that the spacing along z is the scale of the heights. Each square of four samples has two triangles, cut
// from (i, j) to (i + 1, j + 1); squares with a NaN corner (NanPolicy::hole) have none.
//
// The surface is open, or closed by walls and a flat floor below the lowest height. The closed mesh is an oriented
// 2-manifold: where squares touch at a corner only, each has a vertex of its own. Without holes the floor is a fan
// around its middle; with holes it repeats the squares. Without holes the volume is that of the trapezoid rule for the
// heights above the floor, plus (h00 - h10 - h01 + h11) / 12 times the area of a square. Here h00 to h11 are the
// heights at the four corners of the data.
#pragma once

#include <array>
#include <optional>

#include "extract/extractor.hpp"

namespace isoextract::extract {

struct HeightOptions {
  static constexpr std::array kMembers{"solid", "base"};

  bool solid = true;           // closed by walls and a floor
  std::optional<double> base;  // value of the floor; default: below the lowest height by a tenth of the range of
                               // heights, or by 1 if all heights are equal

  friend bool operator==(const HeightOptions&, const HeightOptions&) = default;
};

// Returns the surface, without normals and edge keys. Uses only `nan` and `output_from_index` of `options`;
// NanPolicy::outside works like hole. `iso` has no effect.
//
// Fails with ErrorCode::usage for `smooth_normals`, `edge_keys`, and an `iso` that is not finite.
// Fails with ErrorCode::input
// - for a sparse field, more than one sample along z, or fewer than two along x or y,
// - for NaN samples with NanPolicy::error, and for infinite samples,
// - for a solid whose base is not below all heights,
// - for a transform that is singular or not finite, and for coordinates outside the range of float32,
// - for more vertices than 32-bit indices can number.
// Fails with ErrorCode::out_of_memory or cancelled.
[[nodiscard]] Result<Extraction> extract_heights(const field::ScalarField& field, const HeightOptions& heights,
                                                 const ExtractOptions& options, const Context& context);

}  // namespace isoextract::extract

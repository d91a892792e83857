// How large a surface will be, without extracting it.
#pragma once

#include <cstdint>
#include <optional>

#include "field/scalar_field.hpp"

namespace isoextract::field {

struct SurfaceEstimate {
  std::uint64_t vertices = 0;
  std::uint64_t places = 0;
};

// About how many vertices the surface at `iso` has: its crossings of the grid's edges. Of dense samples three times
// those along x, as if it faced every axis alike; of sparse ones all of them, as marching cubes places a vertex on
// each. And about how many places of block size it passes: stored blocks, and places beside them that are not stored;
// and the faces of tiles. A place that several blocks lie beside counts for each. None for dense samples.
[[nodiscard]] SurfaceEstimate estimate_surface(const ScalarField& field, double iso);

// No more vertices than the surface has within the box, and in a placement without NaN samples as many where samples
// are dense: their crossings along all three axes. Of sparse samples those within blocks; none where there is a box.
[[nodiscard]] std::uint64_t count_vertices(const ScalarField& field, double iso, const std::optional<IndexBox>& box);

}  // namespace isoextract::field

// How large a surface will be, without extracting it.
#pragma once

#include <cstdint>
#include <optional>

#include "field/scalar_field.hpp"

namespace isoextract::field {

// About how many vertices the surface at `iso` has: its crossings of the grid's edges. Of dense samples three times
// those along x, as if it faced every axis alike; of sparse ones those within blocks, as many more as leave them, and
// those at the faces of tiles.
[[nodiscard]] std::uint64_t estimate_vertices(const ScalarField& field, double iso);

// No more vertices than the surface has within the box, and in a placement without NaN samples as many where samples
// are dense: their crossings along all three axes. Of sparse samples those within blocks; none where there is a box.
[[nodiscard]] std::uint64_t count_vertices(const ScalarField& field, double iso, const std::optional<IndexBox>& box);

// About how many places of block size the surface at `iso` passes: stored blocks, and places beside them that are not
// stored; and the faces of tiles. A place that several blocks lie beside counts for each. None for dense samples.
[[nodiscard]] std::uint64_t estimate_places(const ScalarField& field, double iso);

}  // namespace isoextract::field

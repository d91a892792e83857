// Estimates the size of a surface without extracting it.
#pragma once

#include <cstdint>
#include <optional>

#include "field/scalar_field.hpp"

namespace isoextract::field {

struct SurfaceEstimate {
  std::uint64_t vertices = 0;  // grid edges that the surface crosses
  std::uint64_t places = 0;    // block-sized places that the surface passes
  std::uint64_t boundary = 0;  // dense: inside samples on the faces of the box
  bool has_nan = false;        // dense: a sample in the box is NaN
};

// Estimates the number of vertices by the grid edges that cross `iso`, as marching cubes places a vertex on each.
// Counts all of them for sparse samples. For dense samples, returns three times the crossings along x, as if the
// surface faced all axes equally. Dense samples count only within `box` (nullopt: all of them).
//
// Also counts block-sized places for sparse samples: stored blocks, empty places beside them, and block-sized parts of
// tile faces that the surface passes. A place beside several blocks counts once for each. Dense samples have none.
[[nodiscard]] SurfaceEstimate estimate_surface(const ScalarField& field, double iso,
                                               const std::optional<IndexBox>& box = std::nullopt);

// Returns a lower bound for the number of marching cubes vertices within `box` (nullopt: among all samples). For dense
// samples it counts the crossings along all three axes, which is exact. For sparse samples it counts crossings within
// blocks, or returns 0 if there is a box. NaN counts as outside, so NanPolicy::hole can give fewer vertices than this.
[[nodiscard]] std::uint64_t min_vertex_count(const ScalarField& field, double iso, const std::optional<IndexBox>& box);

}  // namespace isoextract::field

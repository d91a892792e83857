// Triangulates the region inside closed loops in a plane: any number of polygons, with holes, nested at will. Loops may
// touch themselves and each other.
//
// Bridges join holes to their outlines, then ears are clipped off the resulting polygons (D. Eberly, Triangulation by
// Ear Clipping, 2002). This uses every loop edge once and adds no points. An ear may touch the rest of its polygon but
// must not overlap it; all signs are exact. Then edges are flipped until each is locally Delaunay (C. L. Lawson,
// Software for C1 surface interpolation, 1977).
//
// Rounding can make loops cross, or flatten a loop to zero width: every triangulation then has overlaps. Even then the
// triangles close the loops; only their positions suffer, not their connectivity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/context.hpp"
#include "base/error.hpp"

namespace isoextract::edit {

struct LoopTriangles {
  std::vector<glm::uvec3> triangles;  // counter-clockwise
  // New points, numbered after the given ones: each is the midpoint of two points. They split edges that would occur
  // twice.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> midpoints;
  std::uint64_t turned = 0;  // triangles that run clockwise and are wider than rounding: they overlap other triangles
};

// Fills the region on the left of the loops. `points` must have coordinates that float32 represents exactly. `next` is
// the following point along each loop, a permutation without cycles shorter than three. No inner edge joins a pair in
// `taken` (smaller point first). `rounding` is how far a point may be from its exact position.
//
// Fails with ErrorCode::input if a loop has no inside, with ErrorCode::out_of_memory if memory is short, or with
// ErrorCode::cancelled.
[[nodiscard]] Result<LoopTriangles> triangulate_loops(std::span<const glm::dvec2> points,
                                                      std::span<const std::uint32_t> next,
                                                      std::span<const std::pair<std::uint32_t, std::uint32_t>> taken,
                                                      double rounding, const Context& context);

}  // namespace isoextract::edit

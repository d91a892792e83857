// Triangles that fill closed loops in a plane: polygons with holes, several of them, nested at will, which may touch
// themselves and each other.
//
// Holes are joined to what is left of them by bridges, and ears are cut off the polygons that result (D. Eberly,
// Triangulation by Ear Clipping, 2002), which uses every edge of the loops once and adds no points. An ear may touch
// the rest of its polygon, and nothing may run into it; all signs are exact. Then edges are flipped until each is
// locally Delaunay (C. L. Lawson, Software for C1 surface interpolation, 1977).
//
// Where rounding made loops cross each other, or a loop of a width of 0, no triangulation is without overlap. Then,
// too, the triangles close the loops: what suffers is where triangles lie, not how they hang together.
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
  // Points in the middle of two others, numbered after the given ones: of edges that there would be twice.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> midpoints;
  std::uint64_t turned = 0;  // triangles that run clockwise, and are wider than rounding: they overlap others
};

// `points` have coordinates that float32 holds, and `next` says what follows each along its loop, a permutation without
// cycles of fewer than three. What is filled lies on the left. No edge within will join what one of `taken` joins:
// pairs of points, the smaller first. `rounding` is how far points may be from where they should be. Memory is
// reserved; fails where it is not there, and with ErrorCode::cancelled.
[[nodiscard]] Result<LoopTriangles> triangulate_loops(std::span<const glm::dvec2> points,
                                                      std::span<const std::uint32_t> next,
                                                      std::span<const std::pair<std::uint32_t, std::uint32_t>> taken,
                                                      double rounding, const Context& context);

}  // namespace isoextract::edit

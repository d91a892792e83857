// Whether two triangles have a point in common besides the corners and the side that they share. Exact.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::check {

struct PlacedTriangle {
  std::array<glm::dvec3, 3> corners;  // float32 coordinates, not on one line
  glm::uvec3 places;                  // equal numbers: the same coordinates; other numbers: others
};

struct TriangleOverlap {
  bool meet = false;
  bool in_one_plane = false;  // both triangles; told where they meet
  bool neighbours = false;    // they share a corner or a side; likewise
};

// Triangles are with their border: touching is meeting. They may share up to two corners.
//
// Without a shared corner they meet where a side of one meets the other. Where they share one corner, what they have in
// common is convex and holds it: if there is more, it reaches the side opposite to the corner in one of them. Where
// they share a side, there is more where they lie in one plane on the same side of it.
[[nodiscard]] TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q);

}  // namespace isoextract::check

// Tests exactly whether two triangles have a common point besides the corner or the edge that they share.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::mesh {

struct PlacedTriangle {
  std::array<glm::dvec3, 3> corners;  // float32 coordinates, not on one line
};

struct TriangleOverlap {
  bool meet = false;
  bool in_one_plane = false;  // only set if they meet
  bool neighbors = false;     // they share a corner or a side; only set if they meet
};

// Triangles include their border, so touching is meeting. Corners with equal coordinates are shared. Triangles that
// share all three corners meet.
//
// Without a shared corner, two triangles meet if a side of one meets the other. With one shared corner, their
// intersection is convex and contains it; if it holds more, it reaches the opposite side of one triangle. With a shared
// side, they overlap if they lie in one plane on the same side of it.
[[nodiscard]] TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q);

}  // namespace isoextract::mesh

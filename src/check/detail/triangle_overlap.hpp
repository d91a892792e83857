// Tests exactly whether two triangles have a common point besides the corner or the edge that they share.
#pragma once

#include <array>
#include <cstdint>

#include <glm/glm.hpp>

namespace isoextract::check {

struct PlacedTriangle {
  std::array<glm::dvec3, 3> corners;  // float32 coordinates, not on one line
  glm::uvec3 places;                  // equal numbers: equal coordinates; different numbers: different ones
};

struct TriangleOverlap {
  bool meet = false;
  bool in_one_plane = false;  // only set if they meet
  bool neighbors = false;     // they share a corner or a side; only set if they meet
};

// Triangles include their border, so touching is meeting. They may share up to two corners.
//
// Without a shared corner, two triangles meet if a side of one meets the other. With one shared corner, their
// intersection is convex and contains it; if it holds more, it reaches the opposite side of one triangle. With a shared
// side, they overlap if they lie in one plane on the same side of it.
[[nodiscard]] TriangleOverlap find_overlap(const PlacedTriangle& p, const PlacedTriangle& q);

}  // namespace isoextract::check

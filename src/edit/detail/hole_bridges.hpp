// Joins the holes of polygons to their outlines: see loop_triangulation.hpp.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "edit/detail/polygon_ears.hpp"

namespace isoextract::edit {

struct BridgedLoops {
  std::vector<PolygonNode> nodes;                                // of all polygons
  std::vector<std::uint32_t> polygons;                           // one node of each polygon
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bridges;  // of each: the start nodes of its two directions
};

// Turns the loops of `next` into polygons without holes. A bridge (an edge there and back) joins each clockwise loop to
// the outline that it sees on its left. A loop that sees none, or has no area, becomes a polygon of its own.
[[nodiscard]] BridgedLoops bridge_holes(std::span<const glm::dvec2> points, std::span<const std::uint32_t> next);

}  // namespace isoextract::edit

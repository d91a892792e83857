// Holes of polygons joined to what is around them: see loop_triangulation.hpp.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "edit/detail/polygon_ears.hpp"

namespace isoextract::edit {

// The polygons that the loops of `next` bound, each without holes: the nodes of all, and one of each polygon. A loop
// that runs clockwise is joined to what it sees on its left by an edge there and back; where it sees nothing, and where
// a loop has no area, it is a polygon of its own.
struct BridgedLoops {
  std::vector<PolygonNode> nodes;
  std::vector<std::uint32_t> polygons;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> bridges;  // nodes from which one leads there, and back
};

[[nodiscard]] BridgedLoops bridge_holes(std::span<const glm::dvec2> points, std::span<const std::uint32_t> next);

}  // namespace isoextract::edit

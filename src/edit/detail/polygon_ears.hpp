// Ears cut off a polygon: see loop_triangulation.hpp.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::edit {

// A place of a polygon's border. Points where bridges end have several.
struct PolygonNode {
  std::uint32_t point = 0;
  std::uint32_t prev = 0;
  std::uint32_t next = 0;
};

// An edge of a triangle: 3 * triangle + the corner that it starts at.
using HalfEdge = std::uint32_t;
constexpr HalfEdge kNoHalfEdge = std::numeric_limits<HalfEdge>::max();

// Triangles of points, and how they hang together.
struct Ears {
  std::vector<glm::uvec3> triangles;
  std::vector<HalfEdge> twins;    // of each half-edge that across the edge, or kNoHalfEdge
  std::vector<HalfEdge> of_node;  // the half-edge from each node to its next
};

// Cuts the polygon that `first` is of into triangles, added to `ears`. `rounding` is how far points may be from
// where they should be. False where none is left that has
// three different points; then the polygon is not of one piece with an inside.
[[nodiscard]] bool cut_ears(std::span<const glm::dvec2> points, std::span<const PolygonNode> nodes, std::uint32_t first,
                            Ears& ears, double rounding = 0);

}  // namespace isoextract::edit

// Clips ears off a polygon: see loop_triangulation.hpp.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::edit {

// A corner of a polygon. A point where a bridge ends has several nodes.
struct PolygonNode {
  std::uint32_t point = 0;
  std::uint32_t prev = 0;
  std::uint32_t next = 0;
};

// An edge of a triangle: 3 * triangle + the corner where it starts.
using HalfEdge = std::uint32_t;
constexpr HalfEdge kNoHalfEdge = std::numeric_limits<HalfEdge>::max();

// Triangles and their connectivity.
struct Ears {
  std::vector<glm::uvec3> triangles;
  std::vector<HalfEdge> twins;    // the half-edge across each edge, or kNoHalfEdge
  std::vector<HalfEdge> of_node;  // the half-edge from each node to the next
};

// Cuts the polygon of node `first` into triangles and adds them to `ears`; of_node must have an entry for each node of
// `nodes`. `rounding` is how far a point may be from its exact position. Returns false if no three different points are
// left for an ear; the polygon then has no connected inside.
[[nodiscard]] bool clip_ears(std::span<const glm::dvec2> points, std::span<const PolygonNode> nodes,
                             std::uint32_t first, Ears& ears, double rounding = 0);

}  // namespace isoextract::edit

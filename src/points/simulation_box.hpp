// The box of a particle simulation: a parallelepiped that repeats along its periodic edges.
#pragma once

#include <array>
#include <string>

#include <glm/glm.hpp>

#include "field/affine.hpp"

namespace isoextract::points {

// Covers origin + edges * f for fractions f from 0 to 1. In world units.
struct SimulationBox {
  glm::dvec3 origin{0.0};
  glm::dmat3 edges{1.0};                           // columns: the three edges, with any angles between them
  std::array<bool, 3> periodic{true, true, true};  // for each edge: whether the simulation repeats along it

  [[nodiscard]] field::Affine world_from_fractions() const { return {edges, origin}; }
  // Returns whether all numbers are finite and the edges span a volume.
  [[nodiscard]] bool is_valid() const { return world_from_fractions().is_invertible(); }
  [[nodiscard]] bool is_periodic() const { return periodic[0] || periodic[1] || periodic[2]; }
  // Returns whether each edge is parallel to the axis of its number.
  [[nodiscard]] bool is_upright() const {
    return edges == glm::dmat3(edges[0].x, 0, 0, 0, edges[1].y, 0, 0, 0, edges[2].z);
  }

  friend bool operator==(const SimulationBox&, const SimulationBox&) = default;
};

// Returns the box for messages: its corners, or its origin and edges if it is not upright.
[[nodiscard]] std::string box_text(const SimulationBox& box);
// Returns the periodic edges for messages: "x, y", or "none". Edges of a box that is not upright are a, b and c.
[[nodiscard]] std::string periodic_text(const SimulationBox& box);

}  // namespace isoextract::points

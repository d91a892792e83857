// Ears cut off a polygon: see loop_triangulation.hpp.
#pragma once

#include <cstdint>
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

// Cuts the polygon that `first` is of into triangles of points. False where none is left that has
// three different points; then the polygon is not of one piece with an inside.
[[nodiscard]] bool cut_ears(std::span<const glm::dvec2> points, std::span<const PolygonNode> nodes, std::uint32_t first,
                            std::vector<glm::uvec3>& triangles);

}  // namespace isoextract::edit

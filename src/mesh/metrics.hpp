// Sizes of a mesh, summed in double.
#pragma once

#include <cstdint>
#include <span>

#include "mesh/mesh.hpp"

namespace isoextract::mesh {

struct Bounds {
  glm::dvec3 min{0.0};
  glm::dvec3 max{0.0};
};

// Of the positions with the origin added; zero for a mesh without vertices.
[[nodiscard]] Bounds measure_bounds(const Mesh& mesh);

// Of the stored float32 positions, without the origin.
struct LocalBounds {
  glm::vec3 min{0.0F};
  glm::vec3 max{0.0F};
};
[[nodiscard]] LocalBounds measure_local_bounds(const Mesh& mesh);

// The greatest of their absolute coordinates, which says how finely float32 resolves them; 0 where there are none.
[[nodiscard]] float farthest_coordinate(std::span<const glm::vec3> positions);

// A last place of that coordinate: distances up to it are rounding.
[[nodiscard]] inline double float32_resolution(std::span<const glm::vec3> positions) {
  return static_cast<double>(farthest_coordinate(positions)) * 0x1p-23;
}

struct MeshSize {
  double area = 0;
  double volume = 0;  // enclosed; positive if triangles wind counter-clockwise seen from outside. Closed meshes only.
  std::uint64_t zero_area_triangles = 0;  // exactly zero, computed in double from the stored positions
};
[[nodiscard]] MeshSize measure_size(const Mesh& mesh);

}  // namespace isoextract::mesh

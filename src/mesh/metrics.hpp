// Sizes of a mesh, summed in double.
#pragma once

#include <cstdint>

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

struct MeshSize {
  double area = 0;
  double volume = 0;  // enclosed; positive if triangles wind counter-clockwise seen from outside. Closed meshes only.
  std::uint64_t zero_area_triangles = 0;  // exactly zero, computed in double from the stored positions
};
[[nodiscard]] MeshSize measure_size(const Mesh& mesh);

}  // namespace isoextract::mesh
